import { useClickOutside, useMediaQuery } from "@mantine/hooks";
import { useId, useState } from "react";
import { NavLink } from "react-router";
import { AccountLines } from "../access/Account";
import { AlertCount } from "../alerts/marks";
import { useMenu } from "../pages/pages";
import { Tool } from "../ui/Tool";
import classes from "./layout.module.css";

/** Where all pages are in a row; where only the first of them are, as the stylesheet says; below that there is a menu alone. */
const ALL = "(min-width: 90em)";
const FIRST = "(min-width: 64em)";

/** The way to the pages: links in a row as far as there is room, and all of them in a list that a button opens. */
export function Navigation() {
  const pages = useMenu();
  const all = useMedia(ALL);
  const first = useMedia(FIRST);
  return (
    <nav aria-label="Pages" className={classes.navigation}>
      {!all && <Menu pages={pages} counted={!first} />}
      {first && <Pages className={classes.row} pages={pages.filter(({ button }) => !button)} />}
    </nav>
  );
}

function useMedia(query: string): boolean {
  return useMediaQuery(query, false, { getInitialValueInEffect: false });
}

interface MenuProps {
  pages: ReturnType<typeof useMenu>;
  /** Whether the button says how many alerts there are. */
  counted: boolean;
}

function Menu({ pages, counted }: MenuProps) {
  const [opened, setOpened] = useState(false);
  const close = () => setOpened(false);
  const menu = useClickOutside<HTMLDivElement>(close);
  const listId = useId();
  return (
    // biome-ignore lint/a11y/noStaticElementInteractions: Escape closes what its button has opened
    <div ref={menu} className={classes.menu} onKeyDown={(event) => event.key === "Escape" && close()}>
      <Tool
        name="Pages"
        title={undefined}
        pixels={20}
        path="M3 5h18v2H3V5Zm0 6h18v2H3v-2Zm0 6h18v2H3v-2Z"
        aria-expanded={opened}
        aria-controls={listId}
        onClick={() => setOpened(!opened)}
      />
      {counted && (
        <span className={classes.alerts}>
          <AlertCount />
        </span>
      )}
      <div id={listId} hidden={!opened} className={classes.list}>
        <Pages className={classes.links} pages={pages} counted={false} onChoose={close} />
        <AccountLines className={classes.page ?? ""} onChoose={close} />
      </div>
    </div>
  );
}

interface PagesProps {
  className: string | undefined;
  pages: ReturnType<typeof useMenu>;
  /** Whether the overview's link says how many alerts there are. */
  counted?: boolean;
  onChoose?: () => void;
}

function Pages({ className, pages, counted = true, onChoose }: PagesProps) {
  return (
    <div className={className}>
      {pages.map(({ to, name, letter }) => (
        <NavLink
          key={to}
          to={to}
          end={to === "/"}
          className={classes.page ?? ""}
          title={`${name} (g, then ${letter})`}
          onClick={onChoose}
        >
          {name}
          {counted && to === "/" && <AlertCount />}
        </NavLink>
      ))}
    </div>
  );
}
