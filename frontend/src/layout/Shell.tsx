import { Container, Skeleton, Stack } from "@mantine/core";
import { type RefObject, Suspense, useLayoutEffect, useRef } from "react";
import { Outlet, useLocation } from "react-router";
import { LoginEnded } from "../access/Entrance";
import { OpenBanner } from "../access/OpenNotice";
import { openAlerts, together } from "../alerts/order";
import { useSession } from "../api/session";
import { ApprovalBanner } from "../approvals/ApprovalBanner";
import { Parts } from "../extension/context";
import { useFleetTopic } from "../fleet/context";
import { OperationsProvider } from "../operations/context";
import { StopBanner } from "../stop/StopBanner";
import { Guarded } from "../ui/Guarded";
import { TitlePrefixProvider } from "../ui/Section";
import { ConnectionBanner } from "./ConnectionStatus";
import { Header } from "./Header";
import classes from "./layout.module.css";

/** What all pages have: the header with Stop, and what has to be known everywhere. */
export function Shell() {
  const main = useRef<HTMLDivElement>(null);
  const { pathname } = useLocation();
  useFocusOnNavigation(main, pathname);
  const { principal } = useSession();
  const loggedOut = principal === null;
  const alerts = together(openAlerts(useFleetTopic("alerts"))).length;
  return (
    <TitlePrefixProvider value={alerts === 0 ? "" : `(${alerts}) `}>
      <OperationsProvider>
        <a className={classes.skip} href="#main">
          Skip to the page
        </a>
        <Header />
        <Container
          component="main"
          id="main"
          size="xl"
          py="md"
          ref={main}
          tabIndex={-1}
          className={classes.main}
        >
          <Stack gap="md">
            {loggedOut ? <LoginEnded /> : <ConnectionBanner />}
            <StopBanner />
            <Parts at="stops" />
            <ApprovalBanner />
            <OpenBanner />
            <Guarded of={pathname}>
              <Suspense fallback={<PageSkeleton />}>
                <Outlet />
              </Suspense>
            </Guarded>
          </Stack>
        </Container>
      </OperationsProvider>
    </TitlePrefixProvider>
  );
}

/** A new page begins at its top, for the eyes and for the keyboard. */
function useFocusOnNavigation(main: RefObject<HTMLDivElement | null>, pathname: string): void {
  const shown = useRef(pathname);
  // Before the page can be used: later it would take the focus from what was pressed.
  useLayoutEffect(() => {
    if (shown.current === pathname) return;
    shown.current = pathname;
    window.scrollTo(0, 0);
    // The page may come later than a dialog that was opened while it loaded.
    if (document.querySelector("[aria-modal=true]") === null) main.current?.focus({ preventScroll: true });
  }, [main, pathname]);
}

function PageSkeleton() {
  return (
    <Stack gap="md" role="group" aria-busy="true" aria-label="The page is loading">
      <Skeleton height={28} width={180} />
      <Skeleton height={320} />
    </Stack>
  );
}
