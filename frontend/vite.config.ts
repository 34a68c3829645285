import react from "@vitejs/plugin-react";
import { defineConfig } from "vitest/config";
import { documentation } from "./documentation.ts";
import openapi from "./openapi.json" with { type: "json" };
import { precompress } from "./precompress.ts";

const gateway = process.env.DOCK_GATEWAY_URL ?? "http://127.0.0.1:8000";
// Tests write numbers and times in English, whatever the machine speaks. Their time zone is half an hour off UTC, where a
// time that is not converted shows; TZ chooses another one.
if (process.env.VITEST) Object.assign(process.env, { LC_ALL: "en_US", TZ: process.env.TZ ?? "Asia/Kolkata" });

const first = (path: string) => `/${path.split("/")[1]}`;
const apiPaths = new Set([
  ...Object.keys(openapi.paths).map(first),
  "/docs",
  "/openapi.json",
  "/asyncapi.json",
]);

export default defineConfig({
  plugins: [react(), documentation(), precompress()],
  resolve: { tsconfigPaths: true },
  server: {
    fs: { allow: [".", "../docs"] },
    // The Host header is passed on as it is, so that the gateway's check of the Origin holds here too.
    proxy: {
      ...Object.fromEntries([...apiPaths].map((path) => [path, { target: gateway }])),
      "/ws": { target: gateway, ws: true },
    },
  },
  build: {
    target: "es2022",
    chunkSizeWarningLimit: 800,
    // What every page needs is one file, not forty: each has headers, and small files are compressed badly.
    rolldownOptions: { output: { codeSplitting: { groups: [{ name: "common", tags: ["$initial"] }] } } },
  },
  test: {
    testTimeout: 180_000,
    maxWorkers: "100%",
    pool: "threads",
    restoreMocks: true,
    // The files share the modules that they import: to load these for each file takes as long as the tests.
    isolate: false,
    projects: [
      // What needs no page; a file that needs a bit of one says so at its top.
      {
        extends: true,
        test: {
          name: "logic",
          environment: "node",
          include: ["tests/**/*.test.ts"],
          setupFiles: ["tests/clock.ts"],
        },
      },
      {
        extends: true,
        test: {
          name: "pages",
          environment: "jsdom",
          include: ["tests/**/*.test.tsx"],
          setupFiles: ["tests/clock.ts", "tests/setup.ts"],
        },
      },
    ],
  },
});
