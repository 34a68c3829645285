import { Text, UnstyledButton } from "@mantine/core";
import { Link } from "react-router";
import classes from "./access.module.css";
import { useSession } from "./session";
import { useLogOut } from "./useLogOut";

/** What the menu of the header has, below the pages on a phone. */
export function AccountLines({ className, onChoose }: { className: string; onChoose: () => void }) {
  const { required, principal } = useSession();
  const logOut = useLogOut();
  if (!required || principal === null) return null;
  return (
    <div className={classes.lines}>
      <Text size="sm" c="dimmed" px="0.5rem">
        Logged in as {principal.name}, {principal.role}
      </Text>
      {principal.role === "admin" && (
        <>
          <Link to="/ui/tokens" className={className} onClick={onChoose}>
            Tokens
          </Link>
          <Link to="/ui/audit" className={className} onClick={onChoose}>
            Audit
          </Link>
        </>
      )}
      <UnstyledButton className={className} onClick={logOut}>
        Log out
      </UnstyledButton>
    </div>
  );
}
