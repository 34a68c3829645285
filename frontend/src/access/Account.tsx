import { Suspense } from "react";
import { useSession } from "../api/session";
import { lazyPart } from "../ui/lazyPart";
import classes from "./access.module.css";
import { accessWords } from "./OpenNotice";

const AccountMenu = lazyPart(() => import("./AccountMenu"));

/** Who is logged in, or that no login is needed, in the header. On a phone it is in the list of pages. */
export function Account() {
  const state = useSession();
  const words = accessWords(state);
  if (words === null) return null;
  return (
    <div className={classes.account}>
      <Suspense fallback={null}>
        <AccountMenu state={state} words={words} />
      </Suspense>
    </div>
  );
}
