import { Stack, Text, Title } from "@mantine/core";
import { AccountItem, loggedOutNotice, sessionWords, useAccounts } from "../../access/accounts";
import { useForbidden, useSession } from "../../api/session";
import { useWhyNot } from "../../fleet/context";
import { Trouble } from "../../ui/errors";
import { Fact } from "../../ui/Fact";
import { ENTRY_BUTTON, ReasonButton } from "../../ui/ReasonButton";
import { useCommand } from "../../ui/requests";
import { Time } from "../../ui/Time";
import { endPersonSessions, listPeople } from "./requests";

/** Who is logged in with the identity provider; for admins. Nothing can be changed but that. */
export default function PeopleList() {
  const { provider } = useSession();
  const forbidden = useForbidden("GET /people");
  return provider !== null && forbidden === null && <People provider={provider.name} />;
}

function People({ provider }: { provider: string }) {
  const { people, error, refetch, logOut } = usePeople();
  const reason = useWhyNot("GET /people", people !== undefined);
  return (
    <>
      <Title order={2} size="h4">
        Logged in with {provider}
      </Title>
      <Text size="sm" c="dimmed">
        What they may do is decided there, and holds from their next login on. To keep somebody out, block
        them there and log them out here.
      </Text>
      <Trouble what="The people could not be loaded" error={error} onRetry={() => void refetch()} />
      {people?.length === 0 && (
        <Text size="sm" c="dimmed">
          No one is logged in.
        </Text>
      )}
      <Stack component="ul" gap="sm" m={0} p={0} aria-label={`Logged in with ${provider}`}>
        {people?.map((person) => (
          <AccountItem
            key={`${person.name} ${person.subject}`}
            account={{ ...person, created_at: person.logged_in_at }}
            flaw={null}
            begun="Last login"
            buttons={
              <ReasonButton
                {...ENTRY_BUTTON}
                reason={reason}
                aria-label={`Log out ${person.name}`}
                onClick={() => logOut.mutate(person.name, loggedOutNotice(person.name))}
              >
                Log out
              </ReasonButton>
            }
          >
            <Fact name="Logged in">{sessionWords(person.sessions)}</Fact>
            <Fact name="Until">
              <Time value={person.expires_at} />
            </Fact>
            <Fact name={`Id at ${provider}`}>{person.subject}</Fact>
          </AccountItem>
        ))}
      </Stack>
    </>
  );
}

/** Who is logged in with the identity provider, and what ends that. */
function usePeople() {
  const { http, accounts: people, error, refetch, renew } = useAccounts("GET /people", listPeople);
  const logOut = useCommand((name: string) => endPersonSessions(http, name).then(renew));
  return { people, error, refetch, logOut };
}
