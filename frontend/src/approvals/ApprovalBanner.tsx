import { Suspense } from "react";
import { useLocation } from "react-router";
import { useFleetTopic } from "../fleet/context";
import { Guarded } from "../ui/Guarded";
import { lazyPart } from "../ui/lazyPart";
import classes from "./approvals.module.css";

const Question = lazyPart(() => import("./Question"));

/** The goals that wait until a person allows them: approval is a step before any goal is sent. */
export function ApprovalBanner() {
  const approvals = useFleetTopic("approvals");
  const { pathname } = useLocation();
  return (
    <div role="status" className={classes.list}>
      <Guarded of={pathname}>
        <Suspense fallback={null}>
          {approvals.map((approval) => (
            <Question key={approval.id} approval={approval} />
          ))}
        </Suspense>
      </Guarded>
    </div>
  );
}
