import { Anchor, Text, Title } from "@mantine/core";
import { Suspense, useEffect } from "react";
import { Link, Route, Routes } from "react-router";
import { Entrance } from "../access/Entrance";
import { useSession } from "../api/session";
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
const SitesPage = lazyPart(() => import("../sites/SitesPage"));
const SiteMapsPage = lazyPart(() => import("../pages/map/SiteMapsPage"));
const GoalAtSite = lazyPart(() => import("../goals/GoalAtSite"));
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
  const { hub } = useSession();
  return (
    <Entrance>
      <Announcements />
      <Routes>
        <Route path="ui/wall" element={<Wall />} />
        <Route element={<Shell />}>
          <Route index element={<OverviewPage />} />
          <Route path="ui">
            {!hub && <Route path="robot" element={<RobotPage />} />}
            <Route path="map" element={hub ? <SiteMapsPage /> : <MapPage />} />
            <Route path="goals" element={<GoalsPage />} />
            <Route path="goals/:goalId" element={hub ? <GoalAtSite /> : <GoalPage />} />
            {!hub && <Route path="actions" element={<ActionsPage />} />}
            {!hub && <Route path="actions/*" element={<ActionPage />} />}
            <Route path="statistics" element={<StatisticsPage />} />
            {!hub && <Route path="automation" element={<AutomationPage />} />}
            <Route path="notifications" element={<NotificationsPage />} />
            {hub && <Route path="sites" element={<SitesPage />} />}
            {!ofSite && <Route path="users" element={<UsersPage />} />}
            {!ofSite && <Route path="tokens" element={<TokensPage />} />}
            <Route path="audit" element={<AuditPage />} />
            {!hub && <Route path="graph" element={<GraphPage />} />}
          </Route>
          {hub && <Route path="sites/:site/*" element={<ToSite />} />}
          <Route path="*" element={<NotFoundPage />} />
        </Route>
      </Routes>
    </Entrance>
  );
}

/** The page of a site is loaded as a page of its own: it shares nothing with those about all sites. */
function ToSite(): null {
  useEffect(() => window.location.replace(window.location.href), []);
  return null;
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
