import type { Places } from "../../extension/extension";
import { GoalPicture } from "./GoalPicture";

/** The last picture of a listed goal, where it has one. */
export function ListedPicture({ goal }: Places["listedGoal"]) {
  return goal.recording?.picture === true ? <GoalPicture goalId={goal.goal_id} small /> : null;
}
