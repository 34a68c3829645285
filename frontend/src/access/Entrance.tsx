import { type ReactNode, Suspense, useEffect, useState } from "react";
import { session, useSession } from "../api/session";
import { Guarded } from "../ui/Guarded";
import { lazyPart } from "../ui/lazyPart";

const LoginPage = lazyPart(() => import("./LoginPage"));

/**
 * The pages, for those who may see them; a login instead of them for others. Pages that were shown once stay when the login
 * ends: `LoginEnded` says so.
 */
export function Entrance({ children }: { children: ReactNode }) {
  const { required, principal } = useSession();
  const [entered, setEntered] = useState(false);
  if (principal !== null && !entered) setEntered(true);

  // In another tab somebody may have logged in or out meanwhile.
  useEffect(() => {
    if (!required) return;
    window.addEventListener("focus", session.ask);
    return () => window.removeEventListener("focus", session.ask);
  }, [required]);

  if (principal !== null || entered) return children;
  return (
    <Guarded of="login">
      <Suspense fallback={null}>
        <LoginPage />
      </Suspense>
    </Guarded>
  );
}
