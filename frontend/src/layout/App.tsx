import { Anchor, Text, Title } from "@mantine/core";
import { Suspense } from "react";
import { Link, Route, Routes } from "react-router";
import { Entrance } from "../access/Entrance";
import { pageSite } from "../api/site";
import { Announcements } from "../notifications/Announcements";
import OverviewPage from "../pages/overview/OverviewPage";
import RobotPage from "../pages/robot/RobotPage";
import { Guarded } from "../ui/Guarded";
import { lazyPart } from "../ui/lazyPart";
import { usePageTitle } from "../ui/Section";
import { Shell } from "./Shell";

const GoalsPage = lazyPart(() => import("../goals/GoalsPage"));
const GoalPage = lazyPart(() => import("../goals/GoalPage"));
const ActionsPage = lazyPart(() => import("../actions/ActionsPage"));
const ActionPage = lazyPart(() => import("../actions/ActionPage"));
const StatisticsPage = lazyPart(() => import("../statistics/StatisticsPage"));
const AutomationPage = lazyPart(() => import("../automation/AutomationPage"));
const NotificationsPage = lazyPart(() => import("../notifications/NotificationsPage"));
const GraphPage = lazyPart(() => import("../graph/GraphPage"));
const UsersPage = lazyPart(() => import("../access/UsersPage"));
const TokensPage = lazyPart(() => import("../access/TokensPage"));
const AuditPage = lazyPart(() => import("../audit/AuditPage"));
const MapPage = lazyPart(() => import("../pages/map/MapPage"));
const WallPage = lazyPart(() => import("../pages/wall/WallPage"));

/** Without a header: nothing on it is pressed. */
function Wall() {
  return (
    <Guarded of="wall">
      <Suspense fallback={null}>
        <WallPage />
      </Suspense>
    </Guarded>
  );
}

/** The pages, in what they have in common. */
export function App() {
  const ofSite = pageSite() !== null;
  return (
    <Entrance>
      <Announcements />
      <Routes>
        <Route path="ui/wall" element={<Wall />} />
        <Route element={<Shell />}>
          <Route index element={<OverviewPage />} />
          <Route path="ui">
            <Route path="robot" element={<RobotPage />} />
            <Route path="map" element={<MapPage />} />
            <Route path="goals" element={<GoalsPage />} />
            <Route path="goals/:goalId" element={<GoalPage />} />
            <Route path="actions" element={<ActionsPage />} />
            <Route path="actions/*" element={<ActionPage />} />
            <Route path="statistics" element={<StatisticsPage />} />
            <Route path="automation" element={<AutomationPage />} />
            <Route path="notifications" element={<NotificationsPage />} />
            {!ofSite && <Route path="users" element={<UsersPage />} />}
            {!ofSite && <Route path="tokens" element={<TokensPage />} />}
            <Route path="audit" element={<AuditPage />} />
            <Route path="graph" element={<GraphPage />} />
          </Route>
          <Route path="*" element={<NotFoundPage />} />
        </Route>
      </Routes>
    </Entrance>
  );
}

/** For an address that is no page. */
function NotFoundPage() {
  usePageTitle("No such page");
  return (
    <>
      <Title order={1} size="h3">
        There is no such page
      </Title>
      <Text>
        Everything begins at the{" "}
        <Anchor component={Link} to="/">
          overview
        </Anchor>
        .
      </Text>
    </>
  );
}
