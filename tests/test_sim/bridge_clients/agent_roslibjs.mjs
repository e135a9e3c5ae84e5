// Agent on roslibjs that walks from station to station, and prints the messages it received.
// usage: node agent_roslibjs.mjs URL   (in a folder in which roslib is installed)
import { pathToFileURL } from "node:url";

const library = `${process.cwd()}/node_modules/roslib/dist/RosLib.js`;
const ROSLIB = await import(pathToFileURL(library).href);
const stations = [[-10.8, -3.75], [-10.8, 3.75], [-5.0, 3.75], [-5.0, -3.75]];
const heard = { states: 0, clocks: 0, reached: 0, unsafe: 0, topics: 0, services: 0 };

const ros = new ROSLIB.Ros({ url: process.argv[2] });
const topic = (name, messageType) => new ROSLIB.Topic({ ros, name, messageType });
const goal = topic("/ariac_human/goal_position", "geometry_msgs/Point");
const home = topic("/ariac_human/go_home", "std_msgs/Bool");
let next = 0;
const walk_on = () => {
  const [x, y] = stations[next++ % stations.length];
  goal.publish({ x, y, z: 0.0 });
};

ros.on("connection", () => {
  ros.getTopics((answer) => {
    heard.topics = answer.topics.length;
    topic("/ariac_human/state", "ariac_msgs/HumanState").subscribe((state) => {
      heard.states += Number.isFinite(state.human_position.x) ? 1 : 0;
    });
    topic("/clock", "rosgraph_msgs/Clock").subscribe(() => { heard.clocks += 1; });
    topic("/ariac_human/position_reached", "std_msgs/Bool").subscribe(() => {
      heard.reached += 1;
      walk_on();
    });
    topic("/ariac_human/unsafe_distance", "std_msgs/Bool").subscribe((message) => {
      heard.unsafe += 1;
      home.publish({ data: message.data });
      next = 0;
      walk_on();
    });
    topic("/ariac/competition_state", "ariac_msgs/CompetitionState").subscribe((message) => {
      if (message.competition_state === 4) {
        console.log(JSON.stringify(heard));
        process.exit(0);
      }
    });
    const service = new ROSLIB.Service({
      ros, name: "/ariac/move_agv4", serviceType: "ariac_msgs/MoveAGV",
    });
    service.callService({ location: 1 }, (answer) => {
      heard.services += answer.success ? 1 : 0;
      topic("/ariac/start_human", "std_msgs/Bool").subscribe(walk_on);
    });
  });
});
ros.on("error", (error) => { console.error(String(error)); process.exit(1); });
