import { Group, Skeleton, Stack, Text, Title } from "@mantine/core";
import { notifications } from "@mantine/notifications";
import { useState } from "react";
import type { User } from "../api/access";
import { useForbidden } from "../api/permissions";
import { useSession } from "../api/session";
import { useWhyNot } from "../fleet/useWhyNot";
import { Dialog } from "../ui/Dialog";
import { ReasonButton } from "../ui/ReasonButton";
import { RemovalDialog } from "../ui/RemovalDialog";
import { Trouble } from "../ui/Trouble";
import { usePageTitle } from "../ui/usePageTitle";
import { OpenNotice } from "./OpenNotice";
import { PeopleList } from "./PeopleList";
import { UserForm } from "./UserForm";
import { UserItem } from "./UserItem";
import { useUsers } from "./useUsers";
import { loginName } from "./who";

/** Those who log in with a name and a password, or with the identity provider; for admins. */
export default function UsersPage() {
  usePageTitle("Users");
  const forbidden = useForbidden("GET /users");
  const { provider } = useSession();
  const { users, error, refetch, save, remove, logOut } = useUsers();
  /** Who is changed; null for a new user, undefined for no form. */
  const [edited, setEdited] = useState<User | null>();
  const [removed, setRemoved] = useState<User | null>(null);
  const reason = useWhyNot("GET /users", users !== undefined);
  const closeForm = () => {
    setEdited(undefined);
    save.reset();
  };
  const closeRemoval = () => {
    setRemoved(null);
    remove.reset();
  };
  const endSessions = ({ name }: User) =>
    logOut.mutate(name, {
      onSuccess: () => notifications.show({ message: `${name} is logged out everywhere.` }),
      onError: ({ title, detail }) =>
        notifications.show({ color: "red", title: `${name} is still logged in: ${title}`, message: detail }),
    });
  return (
    <Stack gap="md">
      <Group justify="space-between" gap="xs">
        <Title order={1} size="h3">
          Users
        </Title>
        <ReasonButton reason={reason} onClick={() => setEdited(null)}>
          New user
        </ReasonButton>
      </Group>
      <OpenNotice />
      <Trouble what="The users could not be loaded" error={error} onRetry={() => void refetch()} />
      {users !== undefined ? (
        <Stack component="ul" gap="sm" m={0} p={0} aria-label="Users">
          {users.map((user) => (
            <UserItem
              key={user.name}
              user={user}
              reason={reason}
              onEdit={() => setEdited(user)}
              onLogOut={() => endSessions(user)}
              onRemove={() => setRemoved(user)}
            />
          ))}
        </Stack>
      ) : forbidden !== null ? (
        <Text size="sm">{forbidden}</Text>
      ) : (
        error === null && <Skeleton height={90} role="status" aria-label="The users are loading" />
      )}
      {users?.length === 0 && (
        <Text size="sm" c="dimmed">
          No users.
        </Text>
      )}
      {provider !== null && forbidden === null && <PeopleList provider={provider.name} reason={reason} />}
      <Dialog
        opened={edited !== undefined}
        onClose={closeForm}
        title={edited ? `Edit ${edited.name}` : "New user"}
      >
        {edited !== undefined && (
          <UserForm
            user={edited}
            taken={(users ?? []).map(({ name }) => name)}
            save={save}
            onDone={closeForm}
          />
        )}
      </Dialog>
      <RemovalDialog
        title={`Remove ${removed?.name}?`}
        opened={removed !== null}
        onClose={closeRemoval}
        remove={remove}
        onRemove={() => removed !== null && remove.mutate(removed.name, { onSuccess: closeRemoval })}
      >
        <Text size="sm">
          {removed?.name} is logged out everywhere: here at once, at other gateways within 2 s. Goals that{" "}
          {removed?.name} has sent go on, and records keep the name.
        </Text>
        {removed !== null && removed.name === loginName() && (
          <Text size="sm" fw={600}>
            This is you: this page will ask you to log in.
          </Text>
        )}
      </RemovalDialog>
    </Stack>
  );
}
