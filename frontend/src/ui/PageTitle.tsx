import { Group, Title } from "@mantine/core";
import { createContext, type ReactNode, useContext, useEffect } from "react";

/** What stands before the title of every page in the browser's tab, such as `(2) `. */
const TitlePrefixContext = createContext("");

export const TitlePrefixProvider = TitlePrefixContext.Provider;

/** Names the page in the browser's tab. */
export function usePageTitle(title: string): void {
  const prefix = useContext(TitlePrefixContext);
  useEffect(() => {
    document.title = `${prefix}${title} · dock-gateway`;
  }, [prefix, title]);
}

/** The title of a page, on it and in the browser's tab, with what stands at its right. */
export function PageTitle({ title, children }: { title: string; children?: ReactNode }) {
  usePageTitle(title);
  const heading = (
    <Title order={1} size="h3">
      {title}
    </Title>
  );
  if (children === undefined) return heading;
  return (
    <Group justify="space-between" gap="xs">
      {heading}
      {children}
    </Group>
  );
}
