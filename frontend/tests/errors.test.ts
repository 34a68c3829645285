import { unreachable } from "@dock-gateway/client";
import { expect, test } from "vitest";
import document from "../openapi.json";
import { ERROR_WORDS } from "../src/api/errors";

/** As the gateway makes it of the code. */
const own = (code: string) => code.replaceAll("_", " ").toLowerCase();

test("only errors that can occur have words", () => {
  const codes = document.components.schemas.Problem["x-codes"].map(({ code }) => code);
  codes.push(unreachable(null).code, unreachable(new DOMException("", "TimeoutError")).code);
  expect(Object.keys(ERROR_WORDS).filter((code) => !codes.includes(code))).toEqual([]);
});

test("words say more than the gateway's own title", () => {
  for (const [code, { title, advice }] of Object.entries(ERROR_WORDS)) {
    expect(title?.toLowerCase()).not.toBe(own(code));
    expect(title ?? advice, code).not.toBeNull();
  }
});
