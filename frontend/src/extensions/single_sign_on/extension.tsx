import type { Extension } from "../../extension/extension";
import { lazyPart } from "../../ui/lazyPart";
import { ProviderLogin, takeFailure } from "./ProviderLogin";

export const extension: Extension = {
  name: "single_sign_on",
  parts: { login: ProviderLogin, users: lazyPart(() => import("./PeopleList")) },
  start: () => takeFailure(window),
};
