import { Stack, Text, Title } from "@mantine/core";
import { notifications } from "@mantine/notifications";
import type { Person } from "../api/access";
import { ENTRY_BUTTON } from "../ui/EntryCard";
import { Fact } from "../ui/Fact";
import { ReasonButton } from "../ui/ReasonButton";
import { Time } from "../ui/Time";
import { Trouble } from "../ui/Trouble";
import { AccountItem } from "./AccountItem";
import { usePeople } from "./usePeople";
import { sessionWords } from "./words";

/** Who is logged in with the identity provider; for admins. Nothing can be changed but that. */
export function PeopleList({ provider, reason }: { provider: string; reason: string | null }) {
  const { people, error, refetch, logOut } = usePeople();
  const endSessions = ({ name }: Person) =>
    logOut.mutate(name, {
      onSuccess: () => notifications.show({ message: `${name} is logged out everywhere.` }),
      onError: ({ title, detail }) =>
        notifications.show({ color: "red", title: `${name} is still logged in: ${title}`, message: detail }),
    });
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
          Nobody.
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
                onClick={() => endSessions(person)}
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
