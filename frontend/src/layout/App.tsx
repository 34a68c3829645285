import { Anchor, Text, Title } from "@mantine/core";
import { Suspense } from "react";
import { Link, Route, Routes } from "react-router";
import { Entrance } from "../access/Entrance";
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
  return (
    <Entrance>
      <Announcements />
      <Routes>
        <Route path="/ui/wall" element={<Wall />} />
        <Route element={<Shell />}>
          {usePages().map(({ path, Page }) => (
            <Route key={path} path={path} element={<Page />} />
          ))}
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
