import { Group, Paper, Stack, Title } from "@mantine/core";
import { createContext, type ReactNode, useContext, useEffect, useId } from "react";
import { pageSite } from "../api/site";
import { HelpLink } from "./HelpLink";

interface SectionProps {
  title: string;
  /** The heading of the documentation that explains it: `stop#release`. */
  help?: string;
  /** What stands at the right of the title. */
  aside?: ReactNode;
  children: ReactNode;
}

/** A card of the page, as a landmark with its title. */
export function Section({ title, help, aside, children }: SectionProps) {
  const id = useId();
  return (
    <Paper component="section" withBorder radius="md" p={{ base: "md", sm: "lg" }} aria-labelledby={id}>
      <Stack gap="md">
        <Group justify="space-between" align="center" gap="xs">
          <Heading order={2} id={id} title={title} help={help} />
          {aside}
        </Group>
        {children}
      </Stack>
    </Paper>
  );
}

interface HeadingProps {
  /** 1 for a page, 2 for a card. */
  order: 1 | 2;
  title: string;
  help?: string | undefined;
  id?: string;
}

/** A title, and a *?* that leads to what explains it. */
export function Heading({ order, title, help, id }: HeadingProps) {
  return (
    <Group gap={8} wrap="nowrap">
      <Title order={order} size={order === 1 ? "h3" : "h4"} id={id}>
        {title}
      </Title>
      {help !== undefined && <HelpLink to={help} about={title} />}
    </Group>
  );
}

/** What stands before the title of every page in the browser's tab, such as `(2) `. */
const TitlePrefixContext = createContext("");

export const TitlePrefixProvider = TitlePrefixContext.Provider;

/** Names the page in the browser's tab. */
export function usePageTitle(title: string): void {
  const prefix = useContext(TitlePrefixContext);
  useEffect(() => {
    const site = pageSite();
    document.title = `${prefix}${title}${site === null ? "" : ` · ${site}`} · dock-gateway`;
  }, [prefix, title]);
}

/** The title of a page, on it and in the browser's tab, with what stands at its right. */
export function PageTitle({ title, help, children }: { title: string; help?: string; children?: ReactNode }) {
  usePageTitle(title);
  const heading = <Heading order={1} title={title} help={help} />;
  if (children === undefined) return heading;
  return (
    <Group justify="space-between" gap="xs">
      {heading}
      {children}
    </Group>
  );
}
