import type { Extension } from "../../extension/extension";
import { CameraCard } from "./CameraCard";

export const extension: Extension = { name: "cameras", parts: { robotColumn: CameraCard } };
