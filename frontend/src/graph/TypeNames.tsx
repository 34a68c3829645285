import { Code, Text } from "@mantine/core";
import classes from "./graph.module.css";

/** The ROS types of a thing; there is one where all is well. */
export function TypeNames({ types }: { types: readonly string[] }) {
  return (
    <div>
      <Text size="sm" c="dimmed">
        {types.length > 1 ? "Types" : "Type"}
      </Text>
      {types.map((type) => (
        <Code key={type} className={classes.type}>
          {type}
        </Code>
      ))}
    </div>
  );
}
