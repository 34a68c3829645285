import { ActionIcon, Menu } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { Link } from "react-router";
import PasswordDialog from "./PasswordDialog";
import type { Principal } from "./session";
import { useLogOut } from "./useLogOut";

/** Who is logged in, and what they can do about it. */
export default function AccountMenu({ principal: { name, role, kind } }: { principal: Principal }) {
  const logOut = useLogOut();
  const [opened, dialog] = useDisclosure(false);
  return (
    <>
      <Menu position="bottom-end" zIndex={350}>
        <Menu.Target>
          <ActionIcon
            variant="default"
            size="lg"
            aria-label={`Logged in as ${name}, ${role}`}
            title={`Logged in as ${name}, ${role}`}
          >
            <svg width="20" height="20" viewBox="0 0 24 24" aria-hidden="true" fill="currentColor">
              <path d="M12 3a4.5 4.5 0 1 1 0 9 4.5 4.5 0 0 1 0-9Zm0 2a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5Zm0 8.5c4.6 0 8 2.4 8 5.5v2H4v-2c0-3.1 3.4-5.5 8-5.5Zm0 2c-3.5 0-5.9 1.6-6 3.5h12c-.1-1.9-2.5-3.5-6-3.5Z" />
            </svg>
          </ActionIcon>
        </Menu.Target>
        <Menu.Dropdown>
          <Menu.Label>
            {name}, {role}
          </Menu.Label>
          {role === "admin" && (
            <>
              <Menu.Item component={Link} to="/ui/users">
                Users
              </Menu.Item>
              <Menu.Item component={Link} to="/ui/tokens">
                Tokens
              </Menu.Item>
              <Menu.Item component={Link} to="/ui/audit">
                Audit
              </Menu.Item>
            </>
          )}
          {kind === "user" && <Menu.Item onClick={dialog.open}>Change password …</Menu.Item>}
          <Menu.Item onClick={() => logOut()}>Log out</Menu.Item>
          {kind === "user" && <Menu.Item onClick={() => logOut(true)}>Log out everywhere</Menu.Item>}
        </Menu.Dropdown>
      </Menu>
      <PasswordDialog opened={opened} onClose={dialog.close} />
    </>
  );
}
