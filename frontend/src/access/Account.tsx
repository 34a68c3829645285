import { Text, UnstyledButton } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { notifications } from "@mantine/notifications";
import { Suspense } from "react";
import { Link } from "react-router";
import { logOut, logOutEverywhere } from "../api/access";
import { toCommandError } from "../api/errors";
import { hasSession, useSession } from "../api/session";
import { useFleet } from "../fleet/context";
import { lazyPart } from "../ui/lazyPart";
import classes from "./access.module.css";
import { accessWords } from "./OpenNotice";

const AccountMenu = lazyPart(() => import("./AccountMenu"));

/** Who is logged in, or that no login is needed, in the header. On a phone it is in the list of pages. */
export function Account() {
  const state = useSession();
  const words = accessWords(state);
  if (words === null) return null;
  return (
    <div className={classes.account}>
      <Suspense fallback={null}>
        <AccountMenu state={state} words={words} />
      </Suspense>
    </div>
  );
}

const PasswordDialog = lazyPart(() => import("./PasswordDialog"));

/** What the menu of the header has, below the pages on a phone. */
export function AccountLines({ className, onChoose }: { className: string; onChoose: () => void }) {
  const state = useSession();
  const { open_to, principal } = state;
  const words = accessWords(state);
  const logOut = useLogOut();
  const [opened, dialog] = useDisclosure(false);
  if (words === null) return null;
  const isUser = principal?.kind === "user";
  return (
    <div className={classes.lines}>
      <Text size="sm" c="dimmed" px="0.5rem">
        {words}
      </Text>
      {principal?.role === "admin" && (
        <>
          <Link to="/ui/users" className={className} onClick={onChoose}>
            {open_to === null ? "Users" : "What this means"}
          </Link>
          <Link to="/ui/tokens" className={className} onClick={onChoose}>
            Tokens
          </Link>
          <Link to="/ui/audit" className={className} onClick={onChoose}>
            Audit
          </Link>
        </>
      )}
      {isUser && (
        <UnstyledButton className={className} onClick={dialog.open}>
          Change password …
        </UnstyledButton>
      )}
      {open_to === null && (
        <UnstyledButton className={className} onClick={() => logOut()}>
          Log out
        </UnstyledButton>
      )}
      {hasSession(principal?.kind) && (
        <UnstyledButton className={className} onClick={() => logOut(true)}>
          Log out everywhere
        </UnstyledButton>
      )}
      {opened && (
        <Suspense fallback={null}>
          <PasswordDialog opened onClose={dialog.close} />
        </Suspense>
      )}
    </div>
  );
}

/** Logs out here, or everywhere, and loads the page again: nothing that it knew stays in it. */
export function useLogOut(): (everywhere?: boolean) => void {
  const { http } = useFleet();
  return (everywhere = false) =>
    void (everywhere ? logOutEverywhere(http) : logOut(http)).then(
      () => window.location.reload(),
      (error: unknown) => {
        const { title, detail } = toCommandError(error);
        notifications.show({ color: "red", title: `You are still logged in: ${title}`, message: detail });
      },
    );
}
