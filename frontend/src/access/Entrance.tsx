import { Alert, Button, Skeleton, Stack, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { type ReactNode, Suspense, useEffect, useState } from "react";
import { session, useSession } from "../api/session";
import { Dialog } from "../ui/Dialog";
import { Guarded } from "../ui/Guarded";
import { lazyPart } from "../ui/lazyPart";

const LoginPage = lazyPart(() => import("./LoginPage"));

/**
 * The pages, for those who may see them; a login instead of them for others. Pages that were shown once stay when the login
 * ends: `LoginEnded` says so.
 */
export function Entrance({ children }: { children: ReactNode }) {
  const { required, principal } = useSession();
  const [entered, setEntered] = useState(false);
  if (principal !== null && !entered) setEntered(true);

  // Someone may have logged in or out in another tab.
  useEffect(() => {
    if (!required) return;
    window.addEventListener("focus", session.ask);
    return () => window.removeEventListener("focus", session.ask);
  }, [required]);

  if (principal !== null || entered) return children;
  return (
    <Guarded of="login">
      <Suspense fallback={null}>
        <LoginPage />
      </Suspense>
    </Guarded>
  );
}

const LoginForm = lazyPart(() => import("./LoginForm"));

/** Says that what is below is not live, because the login has ended, and leads to another one. */
export function LoginEnded() {
  const [opened, dialog] = useDisclosure(false);
  return (
    <>
      <Alert color="orange" title="Your login has ended">
        <Stack gap="xs" align="flex-start">
          <Text size="sm">
            You were logged out, here or elsewhere, or the login has expired. What you see below is not live,
            and running goals go on. Until you log in, Stop does not work either: use the robot's own
            emergency stop.
          </Text>
          <Button variant="default" onClick={dialog.open}>
            Log in …
          </Button>
        </Stack>
      </Alert>
      <Dialog opened={opened} onClose={dialog.close} title="Log in">
        <Guarded of="login">
          <Suspense fallback={<Skeleton height={240} />}>
            <LoginForm onDone={dialog.close} />
          </Suspense>
        </Guarded>
      </Dialog>
    </>
  );
}
