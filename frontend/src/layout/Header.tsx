import { Anchor, Container, Group, Title } from "@mantine/core";
import { ShortcutsButton } from "../stop/ShortcutsButton";
import { StopButton } from "../stop/StopButton";
import { ActionServerStatus } from "./ActionServerStatus";
import { ColorSchemeSwitch } from "./ColorSchemeSwitch";
import { ConnectionStatus } from "./ConnectionStatus";
import classes from "./layout.module.css";

export function Header() {
  return (
    <header className={classes.header}>
      <Container size="xl" w="100%">
        <div className={classes.bar}>
          <Title order={1} size="h3" className={classes.name}>
            dock-gateway
          </Title>
          <Group gap="xs" className={classes.states}>
            <ConnectionStatus />
            <ActionServerStatus />
          </Group>
          <Group gap="sm" wrap="nowrap" className={classes.actions}>
            <Anchor href="/docs" size="sm" visibleFrom="sm">
              API
            </Anchor>
            <ShortcutsButton />
            <ColorSchemeSwitch />
            <StopButton />
          </Group>
        </div>
      </Container>
    </header>
  );
}
