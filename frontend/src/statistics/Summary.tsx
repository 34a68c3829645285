import { Text } from "@mantine/core";
import type { GoalCounts } from "../api/types";
import { Fact, FactList } from "../ui/Fact";
import { fixed } from "../ui/numbers";
import { Section } from "../ui/Section";
import { sentence } from "../ui/text";
import { CountLink, DurationLink, RateLink } from "./cells";
import classes from "./statistics.module.css";
import { ENDS, tenths } from "./words";

/** All goals of the time together. */
export function Summary({ total }: { total: GoalCounts }) {
  return (
    <Section title="All goals">
      <div className={classes.summary}>
        <FactList>
          <Fact name="Ended">
            <CountLink counts={total} statuses={ENDS} />
          </Fact>
          <Fact name="Success rate">
            <RateLink counts={total} />
          </Fact>
          <Fact name="Median duration">
            <DurationLink counts={total} of="median" unit=" s" />
          </Fact>
          <Fact name="90th percentile">
            <DurationLink counts={total} of="p90" unit=" s" />
          </Fact>
          <Fact name="Retries per goal">{tenths(total.mean_retries)}</Fact>
          {ENDS.map((status) => (
            <Fact key={status} name={sentence(status)}>
              <CountLink counts={total} statuses={[status]} />
            </Fact>
          ))}
        </FactList>
      </div>
      <Text size="sm" c="dimmed">
        Success rate: succeeded goals among the {fixed(total.ended - total.statuses.canceled, 0)} that ended
        and were not canceled. Durations are those of succeeded goals.
      </Text>
    </Section>
  );
}
