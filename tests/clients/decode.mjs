// Decode every message of a recording with @mcap/core and @foxglove: node decode.mjs <folder with node_modules> <file>. Prints JSON, by topic.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const [folder, file] = process.argv.slice(2);
const require = createRequire(`${folder}/package.json`);
const { McapIndexedReader } = require("@mcap/core");
const { loadDecompressHandlers } = require("@mcap/support");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

const data = new Uint8Array(readFileSync(file));
const readable = {
  size: async () => BigInt(data.length),
  read: async (offset, size) => data.subarray(Number(offset), Number(offset + size)),
};
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
const text = (bytes) => new TextDecoder().decode(bytes);
const decoders = new Map();
for (const { id, data } of reader.schemasById.values()) {
  const ros = new MessageReader(parse(text(data), { ros2: true }));
  decoders.set(id, (bytes) => ros.readMessage(bytes));
}
const topics = {};
for await (const message of reader.readMessages()) {
  const { topic, schemaId } = reader.channelsById.get(message.channelId);
  (topics[topic] ??= []).push(decoders.get(schemaId)(message.data));
}
const plain = (_, value) =>
  typeof value === "bigint" ? Number(value) : ArrayBuffer.isView(value) ? Array.from(value) : value;
process.stdout.write(JSON.stringify(topics, plain));
