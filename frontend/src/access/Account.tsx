import { Suspense } from "react";
import { lazyPart } from "../ui/lazyPart";
import classes from "./access.module.css";
import { useSession } from "./session";

const AccountMenu = lazyPart(() => import("./AccountMenu"));

/** Who is logged in, in the header; nothing where the gateway asks for no login. On a phone it is in the list of pages. */
export function Account() {
  const { required, principal } = useSession();
  if (!required || principal === null) return null;
  return (
    <div className={classes.account}>
      <Suspense fallback={null}>
        <AccountMenu principal={principal} />
      </Suspense>
    </div>
  );
}
