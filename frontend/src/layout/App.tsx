import { lazy } from "react";
import { Route, Routes } from "react-router";
import OverviewPage from "../overview/OverviewPage";
import RobotPage from "../robot/RobotPage";
import { NotFoundPage } from "./NotFoundPage";
import { Shell } from "./Shell";

const GoalsPage = lazy(() => import("../goals/GoalsPage"));
const GoalPage = lazy(() => import("../goals/GoalPage"));
const ActionsPage = lazy(() => import("../actions/ActionsPage"));
const ActionPage = lazy(() => import("../actions/ActionPage"));
const GraphPage = lazy(() => import("../graph/GraphPage"));

/** The pages, in what they have in common. */
export function App() {
  return (
    <Routes>
      <Route element={<Shell />}>
        <Route index element={<OverviewPage />} />
        <Route path="ui">
          <Route path="robot" element={<RobotPage />} />
          <Route path="goals" element={<GoalsPage />} />
          <Route path="goals/:goalId" element={<GoalPage />} />
          <Route path="actions" element={<ActionsPage />} />
          <Route path="actions/*" element={<ActionPage />} />
          <Route path="graph" element={<GraphPage />} />
        </Route>
        <Route path="*" element={<NotFoundPage />} />
      </Route>
    </Routes>
  );
}
