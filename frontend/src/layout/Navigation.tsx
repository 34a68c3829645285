import { NavLink } from "react-router";
import { AlertCount } from "../alerts/AlertCount";
import classes from "./layout.module.css";
import { PAGES } from "./pages";

/** The way to the pages. */
export function Navigation() {
  return (
    <nav aria-label="Pages" className={classes.navigation}>
      {PAGES.map(({ to, name, letter }) => (
        <NavLink
          key={to}
          to={to}
          end={to === "/"}
          className={classes.page ?? ""}
          title={`${name} (g, then ${letter})`}
        >
          {name}
          {to === "/" && <AlertCount />}
        </NavLink>
      ))}
    </nav>
  );
}
