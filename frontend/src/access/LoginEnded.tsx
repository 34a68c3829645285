import { Alert, Button, Skeleton, Stack, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { Suspense } from "react";
import { Dialog } from "../ui/Dialog";
import { Guarded } from "../ui/Guarded";
import { lazyPart } from "../ui/lazyPart";

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
