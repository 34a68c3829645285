import { createContext, useContext, useEffect } from "react";

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
