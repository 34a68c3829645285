import { Checkbox, NativeSelect, NumberInput, Text, Textarea, TextInput } from "@mantine/core";
import { MAX_NOTICE, MAX_TIMES, type StepDraft } from "./draft";
import classes from "./missions.module.css";
import { usePlaces } from "./places/places";
import { type FieldsProps, Refused } from "./StepFields";
import { errorAt, INSIDE, MESSAGE } from "./wrong";

/** Where to drive. Several places are kept as they were sent. */
export function PlaceFields({ step, errors, set }: FieldsProps) {
  const { placeId, place, places } = step;
  if (places !== null)
    return (
      <>
        <Text size="sm" c="dimmed">
          Through these places: {places.map(({ x, y }) => `x ${x} m, y ${y} m`).join("; ")}.
        </Text>
        <Refused errors={errors} where="navigate" />
      </>
    );
  const change = (part: Partial<StepDraft["place"]>) => set({ place: { ...place, ...part } }, "navigate");
  return (
    <>
      <PlaceChoice step={step} errors={errors} set={set} />
      {placeId === "" && (
        <div className={classes.fields}>
          <NumberInput
            label="X"
            suffix=" m"
            value={place.x}
            error={errorAt(errors, "navigate.pose.x")}
            onChange={(x) => change({ x })}
          />
          <NumberInput
            label="Y"
            suffix=" m"
            value={place.y}
            error={errorAt(errors, "navigate.pose.y")}
            onChange={(y) => change({ y })}
          />
          <NumberInput
            label="Heading"
            suffix="°"
            value={place.heading}
            error={errorAt(errors, "navigate.pose.yaw")}
            onChange={(heading) => change({ heading })}
          />
          <TextInput
            label="Frame"
            value={place.frame}
            error={errorAt(errors, "navigate.pose.frame")}
            onChange={(event) => change({ frame: event.currentTarget.value })}
          />
        </div>
      )}
      <Refused
        errors={errors.filter(({ path }) => !/^navigate\.(pose\.|place$)/.test(path))}
        where="navigate"
      />
    </>
  );
}

/** Which place, of those that are stored; nothing where there is none. */
function PlaceChoice({ step: { placeId }, errors, set }: FieldsProps) {
  const { data: places = [] } = usePlaces();
  if (places.length === 0 && placeId === "") return null;
  const known = places.map(({ id, name }) => ({ value: id, label: name }));
  const gone = placeId !== "" && !places.some(({ id }) => id === placeId);
  return (
    <div className={classes.fields}>
      <NativeSelect
        label="Drive to"
        value={placeId}
        error={errorAt(errors, "navigate.place")}
        onChange={(event) => set({ placeId: event.currentTarget.value }, "navigate")}
        data={[
          { value: "", label: "A position" },
          ...known,
          ...(gone ? [{ value: placeId, label: placeId }] : []),
        ]}
      />
    </div>
  );
}

const WORDS = {
  call: { name: "Service", placeholder: "/reset", content: "Request" },
  publish: { name: "Topic", placeholder: "/light", content: "Message" },
};

/** A service with its request, or a topic with its message. */
export function MessageFields({ step, kind, errors, set }: FieldsProps & { kind: keyof typeof MESSAGE }) {
  const words = WORDS[kind];
  const { name, content } = MESSAGE[kind];
  return (
    <>
      <div className={classes.fields}>
        <TextInput
          label={words.name}
          description="Its whole name, from / on."
          placeholder={words.placeholder}
          value={step.target}
          error={errorAt(errors, name)}
          onChange={(event) => set({ target: event.currentTarget.value }, kind)}
        />
        <TextInput
          label="Type"
          description="Only if it is not known."
          value={step.type}
          error={errorAt(errors, `${kind}.type`)}
          onChange={(event) => set({ type: event.currentTarget.value }, kind)}
        />
      </div>
      <Textarea
        label={words.content}
        description="JSON. Fields that are left out have their defaults."
        rows={3}
        resize="vertical"
        spellCheck={false}
        classNames={{ input: classes.code ?? "" }}
        value={step.content}
        error={errorAt(errors, content)}
        onChange={(event) => set({ content: event.currentTarget.value }, content)}
      />
    </>
  );
}

/** A sentence for people. */
export function NotifyFields({ step, errors, set }: FieldsProps) {
  return (
    <>
      <TextInput
        label="Text"
        description="Shown as an alert of the robot, and sent to webhooks."
        placeholder="Load me"
        maxLength={MAX_NOTICE}
        value={step.text}
        error={errorAt(errors, "notify.text")}
        onChange={(event) => set({ text: event.currentTarget.value }, "notify.text")}
      />
      <Checkbox
        label="Critical: someone has to act"
        checked={step.critical}
        onChange={(event) => set({ critical: event.currentTarget.checked }, "notify.critical")}
      />
    </>
  );
}

/** The steps inside of a step, as JSON, and how often they are repeated. */
export function BlockFields({ step, kind, errors, set }: FieldsProps & { kind: keyof typeof INSIDE }) {
  const where = INSIDE[kind];
  const wrong = errors.filter(({ path }) => path.startsWith(kind) && path !== "repeat.times");
  const inside = wrong.map(({ path, detail }) => (path === where ? detail : `${path}: ${detail}`));
  return (
    <>
      {kind === "repeat" && (
        <div className={classes.fields}>
          <NumberInput
            label="Times"
            description="Empty: for ever."
            min={1}
            max={MAX_TIMES}
            clampBehavior="none"
            allowDecimal={false}
            value={step.times}
            error={errorAt(errors, "repeat.times")}
            onChange={(times) => set({ times }, "repeat")}
          />
        </div>
      )}
      <Textarea
        label="Steps"
        description={
          kind === "repeat"
            ? "As JSON. They are taken again and again."
            : "As JSON. Each is taken only if those before it have failed."
        }
        rows={5}
        resize="vertical"
        spellCheck={false}
        classNames={{ input: classes.code ?? "" }}
        value={step.content}
        error={inside.length === 0 ? undefined : inside.join("; ")}
        onChange={(event) => set({ content: event.currentTarget.value }, kind)}
      />
    </>
  );
}
