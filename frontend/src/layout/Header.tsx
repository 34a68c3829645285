import { ActionIcon, Anchor, Group, useComputedColorScheme, useMantineColorScheme } from "@mantine/core";
import { Link } from "react-router";
import { Account } from "../access/Account";
import { pageSite } from "../api/site";
import { SearchButton } from "../search/SearchButton";
import { StopButton } from "../stop/StopButton";
import { Icon, Tool } from "../ui/Tool";
import { ConnectionStatus } from "./ConnectionStatus";
import classes from "./layout.module.css";
import { Navigation } from "./Navigation";
import { ShortcutsButton } from "./ShortcutsButton";

export function Header() {
  return (
    <header className={classes.header}>
      <div className={classes.bar}>
        <Name />
        <Navigation />
        <ConnectionStatus />
        <Group gap="sm" wrap="nowrap" className={classes.actions}>
          <Anchor component={Link} to="/ui/help" size="sm" className={classes.wide ?? ""}>
            Help
          </Anchor>
          <NotificationsLink />
          <SearchButton />
          <ShortcutsButton />
          <ColorSchemeSwitch />
          <Account />
          <StopButton />
        </Group>
      </div>
    </header>
  );
}

/** The way to the overview; on the page of a site also to that of all sites. */
function Name() {
  const site = pageSite();
  if (site === null)
    return (
      <Link to="/" className={classes.name}>
        dock-gateway
      </Link>
    );
  return (
    <div className={classes.name}>
      <a href="/" title="dock-gateway: all sites">
        All sites
      </a>
      <span aria-hidden="true"> / </span>
      <Link to="/">{site}</Link>
    </div>
  );
}

const SUN =
  "M12 7a5 5 0 1 0 0 10 5 5 0 0 0 0-10Zm-1-5h2v3h-2V2Zm0 17h2v3h-2v-3ZM2 11h3v2H2v-2Zm17 0h3v2h-3v-2ZM4.2 5.6l1.4-1.4 2.1 2.1-1.4 1.4-2.1-2.1Zm12.1 12.1 1.4-1.4 2.1 2.1-1.4 1.4-2.1-2.1ZM4.2 18.4l2.1-2.1 1.4 1.4-2.1 2.1-1.4-1.4ZM16.3 6.3l2.1-2.1 1.4 1.4-2.1 2.1-1.4-1.4Z";
const MOON = "M20.7 14.6A9 9 0 0 1 9.4 3.3a9 9 0 1 0 11.3 11.3Z";

function ColorSchemeSwitch() {
  const { setColorScheme } = useMantineColorScheme();
  const scheme = useComputedColorScheme("light");
  const other = scheme === "dark" ? "light" : "dark";
  return (
    <Tool
      name={`Use the ${other} colour scheme`}
      path={scheme === "dark" ? SUN : MOON}
      onClick={() => setColorScheme(other)}
    />
  );
}

/** A bell; where it is narrow the page is in the menu. */
function NotificationsLink() {
  return (
    <ActionIcon
      component={Link}
      to="/ui/notifications"
      variant="default"
      size="lg"
      aria-label="Notifications"
      title="Notifications (g, then n)"
      visibleFrom="sm"
    >
      <Icon
        pixels={20}
        path="M12 2a1.5 1.5 0 0 1 1.5 1.5v.7A6 6 0 0 1 18 10v5l2 2v1H4v-1l2-2v-5a6 6 0 0 1 4.5-5.8v-.7A1.5 1.5 0 0 1 12 2Zm0 4a4 4 0 0 0-4 4v6h8v-6a4 4 0 0 0-4-4Zm-2 13h4a2 2 0 0 1-4 0Z"
      />
    </ActionIcon>
  );
}
