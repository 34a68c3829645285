import { NavLink } from "react-router";
import classes from "./layout.module.css";

const PAGES = [
  { to: "/", name: "Overview" },
  { to: "/ui/goals", name: "Goals" },
  { to: "/ui/actions", name: "Actions" },
  { to: "/ui/graph", name: "Graph" },
] as const;

/** The way to the pages. */
export function Navigation() {
  return (
    <nav aria-label="Pages" className={classes.navigation}>
      {PAGES.map(({ to, name }) => (
        <NavLink key={to} to={to} end={to === "/"} className={classes.page ?? ""}>
          {name}
        </NavLink>
      ))}
    </nav>
  );
}
