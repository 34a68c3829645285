import { useClickOutside, useMediaQuery } from "@mantine/hooks";
import { useId, useState } from "react";
import { NavLink } from "react-router";
import { AccountLines } from "../access/Account";
import { AlertCount } from "../alerts/marks";
import { useMenu } from "../pages/pages";
import { Tool } from "../ui/Tool";
import classes from "./layout.module.css";

/** Where there is no room for all pages in a row; layout.module.css has the same. */
const NARROW = "(max-width: 47.9em)";

/** The way to the pages: links in a row, or in a list that a button opens. */
export function Navigation() {
  const menu = useMenu();
  const narrow = useMediaQuery(NARROW, false, { getInitialValueInEffect: false });
  return narrow ? (
    <Menu />
  ) : (
    <nav aria-label="Pages" className={classes.navigation}>
      <Pages className={classes.row} pages={menu.filter(({ button }) => !button)} />
    </nav>
  );
}

function Menu() {
  const [opened, setOpened] = useState(false);
  const close = () => setOpened(false);
  const nav = useClickOutside<HTMLElement>(close);
  const listId = useId();
  return (
    <nav
      ref={nav}
      aria-label="Pages"
      className={classes.menu}
      onKeyDown={(event) => event.key === "Escape" && close()}
    >
      <Tool
        name="Pages"
        title={undefined}
        pixels={20}
        path="M3 5h18v2H3V5Zm0 6h18v2H3v-2Zm0 6h18v2H3v-2Z"
        aria-expanded={opened}
        aria-controls={listId}
        onClick={() => setOpened(!opened)}
      />
      <span className={classes.alerts}>
        <AlertCount />
      </span>
      <div id={listId} hidden={!opened} className={classes.list}>
        <Pages className={classes.links} pages={useMenu()} counted={false} onChoose={close} />
        <AccountLines className={classes.page ?? ""} onChoose={close} />
      </div>
    </nav>
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
