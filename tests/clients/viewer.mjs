// What a viewer does, with Foxglove's own client and decoders: node viewer.mjs <folder with node_modules> <url>. Prints
// what it has seen as JSON.

import { createRequire } from "node:module";

const [folder, url] = process.argv.slice(2);
const require = createRequire(`${folder}/package.json`);
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader, MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { WebSocket } = require("ws");

const DOCK = "/connect_to_charging_dock";
const seen = { decoded: {}, failed: {}, statuses: [] };
const channels = new Map(); // by topic
const services = new Map(); // by name
const readers = new Map(); // by subscription
const waiting = [];

// Resolve with the first value of `find` that is not undefined, looking again whenever something has come.
const until = (find) => {
  const found = find();
  return found !== undefined ? Promise.resolve(found) : new Promise((resolve) => waiting.push({ find, resolve }));
};
const look = () => {
  for (const each of waiting.splice(0)) {
    const found = each.find();
    found === undefined ? waiting.push(each) : each.resolve(found);
  }
};
const definitions = (schema) => parse(schema, { ros2: true });

setTimeout(() => {
  console.error("the viewer waits too long", JSON.stringify({ ...seen, decoded: Object.keys(seen.decoded) }));
  process.exit(1);
}, 90_000);

const socket = new WebSocket(url, ["foxglove.websocket.v1"]);
const client = new FoxgloveClient({ ws: socket });
client.on("error", (error) => {
  console.error(error);
  process.exit(1);
});
client.on("serverInfo", (info) => (seen.capabilities = info.capabilities));
client.on("status", (status) => seen.statuses.push(status.message));
client.on("unadvertise", (ids) => {
  for (const [topic, channel] of channels) {
    if (ids.includes(channel.id)) channels.delete(topic);
  }
});
client.on("advertise", (offered) => {
  for (const channel of offered) {
    channels.set(channel.topic, channel);
    readers.set(client.subscribe(channel.id), [channel.topic, new MessageReader(definitions(channel.schema))]);
  }
  look();
});
client.on("message", ({ subscriptionId, data }) => {
  const [topic, reader] = readers.get(subscriptionId);
  try {
    seen.decoded[topic] = reader.readMessage(data);
  } catch (error) {
    seen.failed[topic] = String(error);
  }
  look();
});
client.on("advertiseServices", (offered) => {
  for (const service of offered) services.set(service.name, service);
  look();
});
const answers = new Map(); // by call
client.on("serviceCallResponse", ({ callId, data }) => answers.set(callId, { data }) && look());
client.on("serviceCallFailure", ({ callId, message }) => answers.set(callId, { message }) && look());
const parameters = new Map(); // by id
client.on("parameterValues", (values) => parameters.set(values.id, values.parameters) && look());

let calls = 0;
const call = async (name, request) => {
  const service = await until(() => services.get(name));
  const callId = ++calls;
  const writer = new MessageWriter(definitions(service.request.schema));
  client.sendServiceCallRequest({ serviceId: service.id, callId, encoding: "cdr", data: writer.writeMessage(request) });
  const { data, message } = await until(() => answers.get(callId));
  return message ?? new MessageReader(definitions(service.response.schema)).readMessage(data);
};
const status = (text) => until(() => seen.statuses.find((each) => each.includes(text)));

seen.sent = await call(`${DOCK}/send_goal`, {});
await until(() => seen.decoded[`${DOCK}/_action/feedback`]);
const { result, ...ended } = await call(`${DOCK}/get_result`, { goal_id: seen.sent.goal_id });
seen.ended = ended;
seen.battery = result.final_battery_state.power_supply_status;
seen.unknown = await call(`${DOCK}/cancel_goal`, { goal_id: "none" });
seen.trigger = await call("/dock_simulator/reset", {});

const [own, other] = process.argv.slice(4);
client.setParameters([{ name: own, value: false }], "own");
seen.parameters = await until(() => parameters.get("own"));
client.setParameters([{ name: other, value: true }], "other");
seen.refused = await status("--allow-parameters");

const chatter = { topic: "/chatter", encoding: "cdr", schemaName: "std_msgs/msg/String" };
const text = new MessageWriter(definitions("string data"));
const publish = (channel) => client.sendMessage(channel, text.writeMessage({ data: "hello" }));
const channel = client.advertise(chatter);
publish(channel);
await until(() => channels.get("/chatter"));
const again = setInterval(() => publish(channel), 200); // until it is subscribed to
seen.chatter = await until(() => seen.decoded["/chatter"]?.data);
clearInterval(again);
client.advertise({ ...chatter, topic: "/cmd_vel" });
seen.unpublished = await status("--allow-publish '/cmd_vel'");

seen.topics = Object.keys(seen.decoded).sort();
seen.decoded = undefined;
client.close();
console.log(JSON.stringify(seen));
process.exit(0);
