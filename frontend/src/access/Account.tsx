import { Text, UnstyledButton } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { notifications } from "@mantine/notifications";
import { Suspense } from "react";
import { Link } from "react-router";
import { logOut, logOutEverywhere } from "../api/access";
import { toClientError } from "../api/errors";
import { hasSession, useSession } from "../api/session";
import { pageSite } from "../api/site";
import { useExtensions } from "../extension/context";
import { pagesOf } from "../extension/extension";
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

/** Its code comes when it is opened. */
export function AccountPassword({ opened, onClose }: { opened: boolean; onClose: () => void }) {
  return (
    opened && (
      <Suspense fallback={null}>
        <PasswordDialog opened onClose={onClose} />
      </Suspense>
    )
  );
}

interface AccountEntry {
  name: string;
  /** The page that it leads to, or what it does. */
  to?: string;
  onClick?: () => void;
}

/** What whoever is logged in can do about it, in the order of the menu. */
export function useAccountEntries(onPassword: () => void): AccountEntry[] {
  const { open_to, principal } = useSession();
  const pages = pagesOf(useExtensions());
  const logOut = useLogOut();
  const entries: AccountEntry[] = [];
  if (principal?.role === "admin") {
    // On the page of a site people and tokens are those of the server, whose own pages have them.
    if (pageSite() === null) {
      entries.push({ name: open_to === null ? "Users" : "What this means", to: "/ui/users" });
      entries.push({ name: "Tokens", to: "/ui/tokens" });
    }
    for (const { adminMenu, path } of pages)
      if (adminMenu !== undefined) entries.push({ name: adminMenu, to: path });
  }
  if (principal?.kind === "user") entries.push({ name: "Change password …", onClick: onPassword });
  if (open_to === null) entries.push({ name: "Log out", onClick: () => logOut() });
  if (hasSession(principal?.kind)) entries.push({ name: "Log out everywhere", onClick: () => logOut(true) });
  return entries;
}

/** What the menu of the header has, below the pages on a phone. */
export function AccountLines({ className, onChoose }: { className: string; onChoose: () => void }) {
  const words = accessWords(useSession());
  const [opened, dialog] = useDisclosure(false);
  const entries = useAccountEntries(dialog.open);
  if (words === null) return null;
  return (
    <div className={classes.lines}>
      <Text size="sm" c="dimmed" px="0.5rem">
        {words}
      </Text>
      {entries.map(({ name, to, onClick }) =>
        to !== undefined ? (
          <Link key={name} to={to} className={className} onClick={onChoose}>
            {name}
          </Link>
        ) : (
          <UnstyledButton key={name} className={className} onClick={onClick}>
            {name}
          </UnstyledButton>
        ),
      )}
      <AccountPassword opened={opened} onClose={dialog.close} />
    </div>
  );
}

/** Logs out here, or everywhere, and loads the page again: nothing that it knew stays in it. */
function useLogOut(): (everywhere?: boolean) => void {
  const { http } = useFleet();
  return (everywhere = false) =>
    void (everywhere ? logOutEverywhere(http) : logOut(http)).then(
      () => window.location.reload(),
      (error: unknown) => {
        const { title, detail } = toClientError(error);
        notifications.show({ color: "red", title: `You are still logged in: ${title}`, message: detail });
      },
    );
}
