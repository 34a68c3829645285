import { mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { brotliDecompressSync, gunzipSync } from "node:zlib";
import { afterEach, beforeEach, expect, it } from "vitest";
import { precompressFolder } from "../precompress";

let folder = "";
beforeEach(() => {
  folder = mkdtempSync(join(tmpdir(), "precompress-"));
  mkdirSync(join(folder, "assets"));
});
afterEach(() => rmSync(folder, { recursive: true }));

it.each(["index.html", "assets/index.js", "assets/index.css", "assets/icon.svg"])("compresses %s", (name) => {
  const content = Buffer.from("Ümlaute und mehr; ".repeat(500));
  const path = join(folder, name);
  writeFileSync(path, content);
  precompressFolder(folder);
  const [brotli, gzip] = [readFileSync(`${path}.br`), readFileSync(`${path}.gz`)];
  expect(content.equals(brotliDecompressSync(brotli))).toBe(true);
  expect(content.equals(gunzipSync(gzip))).toBe(true);
  expect(Math.max(brotli.length, gzip.length)).toBeLessThan(content.length / 10);
});

it("leaves small files and pictures alone", () => {
  writeFileSync(join(folder, "small.js"), "1");
  writeFileSync(join(folder, "photo.png"), "x".repeat(5000));
  precompressFolder(folder);
  expect(readdirSync(folder).sort()).toEqual(["assets", "photo.png", "small.js"]);
});
