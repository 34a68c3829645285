import type { Extension } from "../../extension/extension";
import { useGoalPictures } from "./pictured";
import { RecordedPicture, RecordingButton } from "./RecordingButton";
import { useReplay } from "./replay";

export const extension: Extension = {
  name: "recordings",
  parts: { goalHead: RecordedPicture, goalCommands: RecordingButton },
  goalMarks: useGoalPictures,
  replay: useReplay,
};
