import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";

export const extension: Extension = {
  name: "audit_log",
  pages: [
    {
      path: "/ui/audit",
      Page: lazyPart(() => import("./AuditPage")),
      adminMenu: "Audit",
    },
  ],
};
