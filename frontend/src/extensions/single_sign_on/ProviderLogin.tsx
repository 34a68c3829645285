import { Alert, Anchor, Button, Stack, Text } from "@mantine/core";
import { useSession } from "../../api/session";

/** Leads to the identity provider, where people log in; nothing where there is none. */
export function ProviderLogin() {
  const { provider } = useSession();
  if (provider === null) return null;
  const { name, logout_url } = provider;
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

/** Where a login with the identity provider begins; it leads back to this page. */
function loginAddress({ pathname, search }: Location): string {
  return `/session/oidc?${new URLSearchParams({ page: pathname + search })}`;
}

const PARAMETER = "login_error";
let failure: string | null = null;

/** Takes out of the address why a login with the identity provider has failed; to be called before the page is shown. */
export function takeFailure({ location, history }: Window): void {
  const url = new URL(location.href);
  failure = url.searchParams.get(PARAMETER);
  if (failure === null) return;
  url.searchParams.delete(PARAMETER);
  history.replaceState(history.state, "", url);
}

/** Why the login before this page has failed, in a sentence; null where none has. */
function failureWords(provider: string): string | null {
  switch (failure) {
    case null:
      return null;
    case "role_required":
      return `${provider} knows you, but you have no role here. Ask an admin for one.`;
    case "provider_unavailable":
      return `${provider} does not answer. Try again in a minute, or log in with a password or a token.`;
    case "history_unavailable":
      return "The gateway's database does not answer. Try again in a minute.";
    case "too_many_logins":
      return "There were too many failed logins. Try again in some minutes.";
    default:
      return "The login was canceled, took too long, or was begun in another tab as well. Try again.";
  }
}
