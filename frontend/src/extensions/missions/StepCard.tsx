import { Group, Text } from "@mantine/core";
import { useGatewayNow } from "../../clock/clock";
import { Tool } from "../../ui/Tool";
import { ActionFields } from "./ActionFields";
import { isBlock, type StepDraft } from "./draft";
import { BlockFields, MessageFields, NotifyFields, PlaceFields } from "./FurtherFields";
import classes from "./missions.module.css";
import { DockFields, type Edit, Refused } from "./StepFields";
import { Options } from "./StepOptions";
import { WaitFields } from "./WaitFields";
import { FormSwitch, WrittenFields } from "./WrittenFields";
import { actionWords } from "./words";
import { stepErrors, type Wrong } from "./wrong";

/** An arrow, on 24 by 24. */
export const UP = "M12 5.5 5 12.5l1.4 1.4 4.6-4.6V19h2V9.3l4.6 4.6 1.4-1.4Z";
export const DOWN = "M12 18.5l7-7-1.4-1.4-4.6 4.6V5h-2v9.7l-4.6-4.6L5 11.5Z";
const CROSS = "M6.4 5 5 6.4l5.6 5.6L5 17.6 6.4 19l5.6-5.6 5.6 5.6 1.4-1.4-5.6-5.6L19 6.4 17.6 5 12 10.6Z";

export const TITLES: Record<StepDraft["kind"], string> = {
  dock: "Dock",
  undock: "Undock",
  navigate: "Drive",
  action: "Action",
  wait: "Wait",
  notify: "Tell people",
  call: "Call",
  publish: "Publish",
  repeat: "Repeat",
  first_that_works: "Alternatives",
  json: "JSON",
};

interface StepCardProps {
  step: StepDraft;
  index: number;
  /** Of all steps. */
  count: number;
  robot: string;
  /** The names of the steps behind it. */
  later: readonly string[];
  /** Whether somebody has tried to start the mission: then also what is missing is said. */
  tried: boolean;
  /** Whether it can be written as JSON, where any value may be a parameter. */
  written: boolean;
  onChange: Edit;
  onMove: (by: -1 | 1) => void;
  onRemove: () => void;
}

/** A step to fill in, to move and to remove. */
export function StepCard({
  step,
  index,
  count,
  robot,
  later,
  tried,
  written,
  onChange,
  onMove,
  onRemove,
}: StepCardProps) {
  const now = useGatewayNow();
  const number = index + 1;
  const errors: Wrong[] = [
    ...stepErrors(step, now).filter(({ missing }) => tried || !missing),
    ...step.refused,
  ];
  /** Changes fields; what the gateway has refused of them is for it to judge again. */
  const set = (part: Partial<StepDraft>, ...paths: string[]) =>
    onChange((before) => ({
      ...before,
      ...part,
      refused: before.refused.filter(
        ({ path }) => !paths.some((each) => path === each || path.startsWith(`${each}.`)),
      ),
    }));
  const title = step.kind === "action" && step.action !== "" ? actionWords(step.action) : TITLES[step.kind];
  const own = errors.filter(({ path }) => path === "");
  return (
    <li
      className={classes.stepCard}
      data-step={step.key}
      tabIndex={-1}
      aria-label={`Step ${number}: ${title}`}
    >
      <div className={classes.stepHead}>
        <span className={`tabular ${classes.sign}`} aria-hidden="true">
          {number}
        </span>
        <Text fw={600} className={classes.words ?? ""}>
          {title}
        </Text>
        <Group gap={4} wrap="nowrap">
          <Tool
            name={`Move step ${number} up`}
            path={UP}
            data-move="up"
            disabled={index === 0}
            onClick={() => onMove(-1)}
          />
          <Tool
            name={`Move step ${number} down`}
            path={DOWN}
            data-move="down"
            disabled={index === count - 1}
            onClick={() => onMove(1)}
          />
          <Tool name={`Remove step ${number}`} path={CROSS} onClick={onRemove} />
        </Group>
      </div>
      {step.kind === "dock" && <DockFields step={step} robot={robot} errors={errors} set={set} />}
      {step.kind === "undock" && <Refused errors={errors} where="undock" />}
      {step.kind === "action" && (
        <ActionFields step={step} robot={robot} errors={errors} set={set} onChange={onChange} />
      )}
      {step.kind === "navigate" && <PlaceFields step={step} errors={errors} set={set} />}
      {(step.kind === "call" || step.kind === "publish") && (
        <MessageFields step={step} kind={step.kind} errors={errors} set={set} />
      )}
      {isBlock(step.kind) && <BlockFields step={step} kind={step.kind} errors={errors} set={set} />}
      {step.kind === "notify" && <NotifyFields step={step} errors={errors} set={set} />}
      {step.kind === "wait" && <WaitFields step={step} errors={errors} set={set} />}
      {step.kind === "json" ? (
        <WrittenFields step={step} errors={errors} set={set} />
      ) : (
        <Options step={step} later={later} errors={errors} set={set} />
      )}
      {(written || step.kind === "json") && <FormSwitch step={step} now={now} onChange={onChange} />}
      {(step.kind === "json" ? [] : own).map(({ detail }) => (
        <Text key={detail} size="sm" c="var(--mantine-color-error)">
          {detail}
        </Text>
      ))}
    </li>
  );
}
