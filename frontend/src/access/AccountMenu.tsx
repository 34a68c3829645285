import { ActionIcon, Menu } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { Link } from "react-router";
import type { SessionState } from "../api/session";
import { Icon } from "../ui/Tool";
import { AccountPassword, useAccountEntries } from "./Account";

const PERSON =
  "M12 3a4.5 4.5 0 1 1 0 9 4.5 4.5 0 0 1 0-9Zm0 2a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5Zm0 8.5c4.6 0 8 2.4 8 5.5v2H4v-2c0-3.1 3.4-5.5 8-5.5Zm0 2c-3.5 0-5.9 1.6-6 3.5h12c-.1-1.9-2.5-3.5-6-3.5Z";
const OPEN_LOCK =
  "M12 2a5 5 0 0 1 5 5h-2a3 3 0 0 0-6 0v3h9a2 2 0 0 1 2 2v8a2 2 0 0 1-2 2H6a2 2 0 0 1-2-2v-8a2 2 0 0 1 2-2h1V7a5 5 0 0 1 5-5ZM6 12v8h12v-8H6Zm6 2a1.5 1.5 0 0 1 1 2.6V18h-2v-1.4a1.5 1.5 0 0 1 1-2.6Z";

interface AccountMenuProps {
  state: SessionState;
  /** Who is logged in, in words. */
  words: string;
}

/** Who is logged in, or that no login is needed, and what can be done about it. */
export default function AccountMenu({ state: { open_to, principal }, words }: AccountMenuProps) {
  const [opened, dialog] = useDisclosure(false);
  const entries = useAccountEntries(dialog.open);
  return (
    <>
      <Menu position="bottom-end" zIndex={350}>
        <Menu.Target>
          <ActionIcon
            variant={open_to === "network" ? "light" : "default"}
            {...(open_to === "network" ? { color: "red" } : {})}
            size="lg"
            aria-label={words}
            title={words}
          >
            <Icon pixels={20} path={open_to === null ? PERSON : OPEN_LOCK} />
          </ActionIcon>
        </Menu.Target>
        <Menu.Dropdown>
          <Menu.Label>{open_to === null ? `${principal?.name}, ${principal?.role}` : words}</Menu.Label>
          {entries.map(({ name, to, onClick }) =>
            to !== undefined ? (
              <Menu.Item key={name} component={Link} to={to}>
                {name}
              </Menu.Item>
            ) : (
              <Menu.Item key={name} onClick={onClick}>
                {name}
              </Menu.Item>
            ),
          )}
        </Menu.Dropdown>
      </Menu>
      <AccountPassword opened={opened} onClose={dialog.close} />
    </>
  );
}
