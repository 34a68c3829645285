// What a page or a program does with roslib; the same in Node.js and in Chromium.

const once = (start) => new Promise((resolve) => start(resolve));

const late = (_, reject) => setTimeout(() => reject(new Error("the scenario takes too long")), 60_000);

export const scenario = (roslib, url) => Promise.race([play(roslib, url), new Promise(late)]);

async function play({ Action, Ros, Service, Topic }, url) {
  const seen = { statuses: [] };
  const ros = new Ros({});
  ros.on("error", (error) => console.error(error.message ?? error));
  ros.on("status", (status) => seen.statuses.push(status.msg));
  await once((resolve) => {
    ros.on("connection", resolve);
    ros.connect(url);
  });

  seen.topics = (await once((resolve) => ros.getTopics(resolve))).topics;
  const details = await once((resolve) => ros.getMessageDetails("geometry_msgs/msg/Twist", resolve));
  seen.twist = ros.decodeTypeDefs(details);

  seen.scans = {};
  for (const compression of ["none", "png", "cbor", "cbor-raw"]) {
    const topic = new Topic({ ros, name: "/talker0/scan", messageType: "sensor_msgs/msg/LaserScan", compression });
    const message = await once((resolve) => topic.subscribe(resolve));
    topic.unsubscribe();
    const values = message.ranges ?? message.bytes;
    seen.scans[compression] = [values.constructor.name, values.length, values[5]];
  }

  const service = new Service({ ros, name: "/rosapi/get_ros_version", serviceType: "rosapi_msgs/srv/GetROSVersion" });
  seen.version = (await once((resolve) => service.callService({}, resolve))).version;
  const unknown = new Service({ ros, name: "/nobody", serviceType: "std_srvs/srv/Empty" });
  seen.refused = await once((resolve) => unknown.callService({}, () => resolve(null), resolve));

  const chatter = new Topic({ ros, name: "/chatter", messageType: "std_msgs/msg/String" });
  seen.chatter = await once((resolve) => {
    chatter.subscribe(resolve);
    chatter.publish({ data: "hello" });
  });
  // roslib tells a page only of statuses without an id.
  await once((resolve) => {
    ros.on("status", resolve);
    ros.callOnConnection({ op: "publish", topic: "/cmd_vel", msg: { linear: { x: 1 } } });
  });

  if (Action) {
    const action = new Action({ ros, name: "/fibonacci", actionType: "action_tutorials_interfaces/action/Fibonacci" });
    const feedback = [];
    seen.result = await once((resolve) => action.sendGoal({ order: 4 }, resolve, (part) => feedback.push(part), resolve));
    seen.feedback = feedback[0];
    seen.canceled = await once((resolve) => {
      const id = action.sendGoal({ order: 40 }, resolve, () => action.cancelGoal(id), (error) => resolve(String(error)));
    });
  }
  ros.close();
  return seen;
}
