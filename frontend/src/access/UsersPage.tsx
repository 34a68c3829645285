import { Group, Skeleton, Stack, Text } from "@mantine/core";
import { useState } from "react";
import type { User } from "../api/access";
import { useForbidden } from "../api/session";
import { Parts } from "../extension/context";
import { useWhyNot } from "../fleet/context";
import { Dialog, RemovalDialog } from "../ui/Dialog";
import { Empty } from "../ui/Empty";
import { Trouble } from "../ui/errors";
import { Fact } from "../ui/Fact";
import { ENTRY_BUTTON, ReasonButton } from "../ui/ReasonButton";
import { PageTitle } from "../ui/Section";
import { Time } from "../ui/Time";
import { type Example, UserForm } from "./accountForms";
import { AccountItem, loggedOutNotice, sessionWords, useUsers } from "./accounts";
import { OpenNotice } from "./OpenNotice";
import { loginName } from "./who";

/** A user to start from. */
const EXAMPLE: Example = { name: "operator", role: "operator" };

/** Those who log in with a name and a password, or with the identity provider; for admins. */
export default function UsersPage() {
  const forbidden = useForbidden("GET /users");
  const { users, error, refetch, save, remove, logOut } = useUsers();
  /** Who is changed; null for a new user, undefined for no form. */
  const [edited, setEdited] = useState<User | null>();
  const [example, setExample] = useState<Example>();
  const [removed, setRemoved] = useState<User | null>(null);
  const reason = useWhyNot("GET /users", users !== undefined);
  const closeForm = () => {
    setEdited(undefined);
    setExample(undefined);
    save.reset();
  };
  const closeRemoval = () => {
    setRemoved(null);
    remove.reset();
  };
  return (
    <Stack gap="md">
      <PageTitle title="Users" help="access#roles">
        <ReasonButton reason={reason} onClick={() => setEdited(null)}>
          New user
        </ReasonButton>
      </PageTitle>
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
              onLogOut={() => logOut.mutate(user.name, loggedOutNotice(user.name))}
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
        <Empty
          title="No users"
          examples={
            <ReasonButton
              variant="default"
              reason={reason}
              onClick={() => {
                setExample(EXAMPLE);
                setEdited(null);
              }}
            >
              Example: an operator
            </ReasonButton>
          }
        >
          People log in with a name and a password. An operator moves robots; a viewer only watches.
        </Empty>
      )}
      <Parts at="users" />
      <Dialog
        opened={edited !== undefined}
        onClose={closeForm}
        title={edited ? `Edit ${edited.name}` : "New user"}
      >
        {edited !== undefined && (
          <UserForm
            key={edited?.etag}
            user={edited}
            example={example}
            users={users ?? []}
            save={save}
            onShow={(newest) => {
              setEdited(newest);
              save.reset();
            }}
            onDone={closeForm}
          />
        )}
      </Dialog>
      <RemovalDialog
        title={`Remove ${removed?.name}?`}
        opened={removed !== null}
        onClose={closeRemoval}
        remove={remove}
        onRemove={() => removed !== null && remove.mutate(removed, { onSuccess: closeRemoval })}
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

interface UserItemProps {
  user: User;
  /** Why nothing can be changed now; null where it can. */
  reason: string | null;
  onEdit: () => void;
  onLogOut: () => void;
  onRemove: () => void;
}

/** A user: what they may do, and where they are logged in. */
function UserItem({ user, reason, onEdit, onLogOut, onRemove }: UserItemProps) {
  const { name, logged_in_at, disabled, sessions } = user;
  return (
    <AccountItem
      account={user}
      flaw={disabled ? "disabled" : null}
      begun="Added"
      buttons={
        <Group gap="xs">
          <ReasonButton {...ENTRY_BUTTON} reason={reason} aria-label={`Edit ${name}`} onClick={onEdit}>
            Edit
          </ReasonButton>
          <ReasonButton
            {...ENTRY_BUTTON}
            reason={reason ?? (sessions === 0 ? `${name} is not logged in.` : null)}
            aria-label={`Log out ${name}`}
            onClick={onLogOut}
          >
            Log out
          </ReasonButton>
          <ReasonButton {...ENTRY_BUTTON} reason={reason} aria-label={`Remove ${name}`} onClick={onRemove}>
            Remove
          </ReasonButton>
        </Group>
      }
    >
      <Fact name="Last login">{logged_in_at === null ? "Never" : <Time value={logged_in_at} />}</Fact>
      <Fact name="Logged in">{sessionWords(sessions)}</Fact>
    </AccountItem>
  );
}
