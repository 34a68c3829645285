import { Anchor, Text, Title } from "@mantine/core";
import { Suspense, useEffect } from "react";
import { Link, Route, Routes } from "react-router";
import { Entrance } from "../access/Entrance";
import { useSession } from "../api/session";
import { Announcements } from "../notifications/Announcements";
import { usePages } from "../pages/pages";
import { Guarded } from "../ui/Guarded";
import { lazyPart } from "../ui/lazyPart";
import { usePageTitle } from "../ui/Section";
import { Shell } from "./Shell";

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
  const { hub } = useSession();
  return (
    <Entrance>
      <Announcements />
      <Routes>
        <Route path="/ui/wall" element={<Wall />} />
        <Route element={<Shell />}>
          {usePages().map(({ path, Page }) => (
            <Route key={path} path={path} element={<Page />} />
          ))}
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
