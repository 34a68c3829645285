import { Anchor, Container, Group } from "@mantine/core";
import { Link } from "react-router";
import { Account } from "../access/Account";
import { SearchButton } from "../search/SearchButton";
import { StopButton } from "../stop/StopButton";
import { ColorSchemeSwitch } from "./ColorSchemeSwitch";
import { ConnectionStatus } from "./ConnectionStatus";
import classes from "./layout.module.css";
import { Navigation } from "./Navigation";
import { NotificationsLink } from "./NotificationsLink";
import { ShortcutsButton } from "./ShortcutsButton";

export function Header() {
  return (
    <header className={classes.header}>
      <Container size="xl" w="100%" className={classes.container}>
        <div className={classes.bar}>
          <Link to="/" className={classes.name}>
            dock-gateway
          </Link>
          <Navigation />
          <ConnectionStatus />
          <Group gap="sm" wrap="nowrap" className={classes.actions}>
            <Anchor href="/docs" size="sm" className={classes.wide ?? ""}>
              API
            </Anchor>
            <NotificationsLink />
            <SearchButton />
            <ShortcutsButton />
            <ColorSchemeSwitch />
            <Account />
            <StopButton />
          </Group>
        </div>
      </Container>
    </header>
  );
}
