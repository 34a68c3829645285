import { Anchor, Group, Table, Text } from "@mantine/core";
import { Link } from "react-router";
import { useNaming } from "../../fleet/context";
import { robotPath } from "../../fleet/names";
import { fixed } from "../../ui/numbers";
import { Section } from "../../ui/Section";
import { goalsLink, NumberLink, SUCCEEDED } from "./cells";
import { useDockingTimes } from "./dockingTimes";
import classes from "./plots.module.css";
import type { DockingTrend } from "./requests";
import { changeWords, seconds, sparkline, trendWords } from "./trend";
import { statisticsView, type View } from "./view";

const BOX = { width: 132, height: 36, room: 4 };
/** How long docking takes a robot, on its page. */
export default function DockingTimeCard({ trend }: { trend: DockingTrend }) {
  const { robot } = trend;
  const query = statisticsView.write({ ...statisticsView.initial, robot });
  return (
    <Section
      title="Docking time"
      help="extensions/statistics#docking-time"
      aside={
        <Anchor component={Link} to={`/ui/statistics?${query}`} size="sm">
          Statistics
        </Anchor>
      }
    >
      <Group gap="md">
        <Sparkline days={trend.days} />
        <Text size="sm" className={classes.sentence ?? ""}>
          {trendWords(trend)}
        </Text>
      </Group>
    </Section>
  );
}

/** The same of all robots that are chosen; nothing where none has docked in two weeks. */
export function DockingTimes({ view }: { view: View }) {
  const { data = [] } = useDockingTimes(view);
  const naming = useNaming();
  if (data.length === 0) return null;
  return (
    <Section title="Docking time, by week" help="extensions/statistics#docking-time">
      <Table verticalSpacing="xs" horizontalSpacing={8} className={classes.trends ?? ""}>
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Robot</Table.Th>
            <Table.Th visibleFrom="sm">14 days</Table.Th>
            <Table.Th>Last 7 days</Table.Th>
            <Table.Th>7 days before</Table.Th>
            <Table.Th visibleFrom="xs">Change</Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {data.map((trend) => (
            <Table.Tr key={trend.robot}>
              <Table.Th scope="row" className={classes.robot}>
                <Anchor component={Link} to={robotPath(trend.robot)} inherit>
                  {naming.nameOf(trend.robot)}
                </Anchor>
              </Table.Th>
              <Table.Td visibleFrom="sm">
                <Sparkline days={trend.days} />
              </Table.Td>
              <Table.Td>
                <Week week={trend.now} />
              </Table.Td>
              <Table.Td>
                <Week week={trend.before} />
              </Table.Td>
              <Table.Td visibleFrom="xs">
                {trend.change === null ? (
                  <Text span inherit c="dimmed">
                    Not clear
                  </Text>
                ) : (
                  <span title={changeWords(trend) ?? undefined}>{shareWords(trend.change)}</span>
                )}
              </Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
      <Text size="sm" c="dimmed">
        The medians of succeeded docking goals. A change is shown where both weeks have 8 of them, it is 10 %
        or more, and each median is outside of the middle half of the other week.
      </Text>
    </Section>
  );
}

function shareWords(change: number): string {
  return `${fixed(Math.abs(change) * 100, 0)} % ${change > 0 ? "longer" : "less time"}`;
}

/** A week's median, which leads to its goals. */
function Week({ week: { median_s, succeeded, goals_path } }: { week: DockingTrend["now"] }) {
  return (
    <>
      <NumberLink
        text={median_s === null ? "–" : seconds(median_s)}
        to={median_s === null ? null : goalsLink({ goals_path }, SUCCEEDED)}
        label="succeeded docking goals"
      />{" "}
      {median_s !== null && (
        <Text span inherit c="dimmed">
          of {fixed(succeeded, 0)}
        </Text>
      )}
    </>
  );
}

/** The median of each day. The text next to it says the same. */
function Sparkline({ days }: { days: readonly (number | null)[] }) {
  return (
    <svg width={BOX.width} height={BOX.height} className={classes.sparkline} aria-hidden="true">
      <line x1={0} x2={BOX.width} y1={BOX.height - BOX.room} y2={BOX.height - BOX.room} />
      {sparkline(days, BOX).map((run) => (
        <g key={run[0]?.x}>
          <polyline points={run.map(({ x, y }) => `${x},${y}`).join(" ")} />
          {run.map(({ x, y }) => (
            <circle key={x} cx={x} cy={y} r={2} />
          ))}
        </g>
      ))}
    </svg>
  );
}
