import { Suspense } from "react";
import { lazyPart } from "../ui/lazyPart";
import { usePreferences } from "./preferences";

const Announcer = lazyPart(() => import("./Announcer"));

/** On every page, for a browser that is to announce alerts. */
export function Announcements() {
  const { desktop, sound } = usePreferences();
  return (
    (desktop || sound) && (
      <Suspense>
        <Announcer />
      </Suspense>
    )
  );
}
