import { Alert, Anchor, Button, Stack, Text } from "@mantine/core";
import type { Provider } from "../api/session";
import { failureWords, loginAddress } from "./provider";

/** Leads to the identity provider, where people log in. */
export function ProviderLogin({ provider: { name, logout_url } }: { provider: Provider }) {
  const failure = failureWords(name);
  return (
    <Stack gap="xs">
      {failure !== null && (
        <Alert color="red" title={`The login with ${name} has failed`}>
          {failure}
        </Alert>
      )}
      <Button component="a" href={loginAddress(window.location)} styles={{ label: { whiteSpace: "normal" } }}>
        Log in with {name}
      </Button>
      {logout_url !== null && (
        <Text size="sm" c="dimmed" ta="center">
          As somebody else?{" "}
          <Anchor href={logout_url} underline="always">
            Log out at {name}
          </Anchor>{" "}
          first.
        </Text>
      )}
      <Text size="sm" c="dimmed" ta="center">
        or
      </Text>
    </Stack>
  );
}
