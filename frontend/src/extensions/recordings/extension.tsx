import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";
import { LinkedRecording } from "./LinkedRecording";
import { ListedPicture } from "./ListedPicture";
import { RecordedPicture, RecordingButton } from "./RecordingButton";

export const extension: Extension = {
  name: "recordings",
  parts: {
    goalHead: RecordedPicture,
    goalCommands: RecordingButton,
    goalPanels: lazyPart(() => import("./GoalLog")),
    linkedGoal: LinkedRecording,
    listedGoal: ListedPicture,
    replay: lazyPart(() => import("./replay")),
  },
};
