import type { Extension } from "../../extension/extension";
import { ApprovalBanner } from "./ApprovalBanner";

export const extension: Extension = { name: "agents", parts: { banners: ApprovalBanner } };
