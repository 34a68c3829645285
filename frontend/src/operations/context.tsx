import type { Robot } from "@dock-gateway/client";
import { createContext, type ReactNode, useCallback, useContext, useRef, useState } from "react";
import { toClientError } from "../api/errors";
import { createGoalsApi } from "../api/goals";
import { MoveDialog, useAskingWanted } from "../docking/MoveDialog";
import { useFleet, useFleetLive, useFleetPart } from "../fleet/context";
import { isThere } from "../fleet/words";
import { useStopping } from "../stop/everywhere";
import { cancelable, fewAtOnce, moveOf, type Operation, type Refusal, whyNot } from "./operation";
import { ManyDialog, ResultsNotice } from "./results";

/** Does something to robots, after a confirmation where one is needed. */
type Operate = (operation: Operation, names: readonly string[]) => void;

const OperateContext = createContext<Operate>(() => {});

export function useOperate(): Operate {
  return useContext(OperateContext);
}

interface Question {
  operation: Operation;
  names: readonly string[];
}

/**
 * Gives what is inside the operations on robots, with their confirmation and results. Several robots are always asked
 * about, one where the controls on its page would ask, and a Stop never.
 */
export function OperationsProvider({ children }: { children: ReactNode }) {
  const { store } = useFleet();
  const [wanted] = useAskingWanted();
  const [question, setQuestion] = useState<Question | null>(null);
  const [opened, setOpened] = useState(false);
  const run = useRun();
  const stop = useStopping();

  const operate = useCallback<Operate>(
    (operation, names) => {
      if (names.length === 0) return;
      if (operation === "stop") return void stop(isEvery(names, store.get("robots")) ? null : names);
      const real = names.some((name) => store.get("robots").get(name)?.simulated === false);
      const asks = names.length > 1 || (moveOf(operation) !== null && wanted && real);
      if (!asks) return run(operation, names);
      setQuestion({ operation, names });
      setOpened(true);
    },
    [store, wanted, run, stop],
  );
  const close = () => setOpened(false);
  const go = (names: readonly string[]) => {
    close();
    if (question !== null) run(question.operation, names);
  };

  return (
    <OperateContext.Provider value={operate}>
      {children}
      {question !== null &&
        (question.names.length === 1 ? (
          <OneDialog question={question} opened={opened} onGo={go} onClose={close} />
        ) : (
          <ManyDialog {...question} opened={opened} onGo={go} onClose={close} />
        ))}
    </OperateContext.Provider>
  );
}

/** Whether these are all robots: one stop then holds them all, and one release ends it. */
function isEvery(names: readonly string[], robots: ReadonlyMap<string, Robot>): boolean {
  const there = [...robots.values()].filter(isThere);
  return names.length > 1 && there.every(({ name }) => names.includes(name));
}

interface OneDialogProps {
  question: Question;
  opened: boolean;
  onGo: (names: readonly string[]) => void;
  onClose: () => void;
}

function OneDialog({ question: { operation, names }, opened, onGo, onClose }: OneDialogProps) {
  const live = useFleetLive();
  const [name = "/"] = names;
  const naming = useFleetPart("naming", (naming) => naming);
  const reason = useFleetPart("robots", (robots) => {
    const robot = robots.get(name);
    return robot === undefined ? "It has left the ROS graph." : whyNot(operation, robot, live);
  });
  return (
    <MoveDialog
      opened={opened}
      verb={moveOf(operation) ?? "dock"}
      robot={naming.fullNameOf(name)}
      reason={reason}
      onMove={() => onGo(names)}
      onClose={onClose}
    />
  );
}

/** Sends to each robot, a few at a time. What has changed since is looked at for each: a Stop ends the rest. */
function useRun(): Operate {
  const { http, gatewayOf, store } = useFleet();
  const sending = useRef(new Set<string>());
  return useCallback(
    (operation, names) => {
      const sent: string[] = [];
      const refused: Refusal[] = [];
      const results = { operation, count: names.length, sent, refused };
      const notice = new ResultsNotice(store.get("naming"), results);
      const send = async (name: string) => {
        if (operation === "dock") return gatewayOf(name).dock(null);
        if (operation === "undock") return gatewayOf(name).undock();
        const goals = store.get("robots").get(name);
        return Promise.all(
          (goals === undefined ? [] : cancelable(goals)).map((goal) =>
            createGoalsApi(http).cancel(goal.goal_id),
          ),
        );
      };
      void fewAtOnce(names, async (name) => {
        const reason = reasonOf(operation, name, sending.current.has(name));
        if (reason !== null) refused.push({ name, reason });
        else {
          sending.current.add(name);
          try {
            await send(name);
            sent.push(name);
          } catch (error) {
            const { title, detail, code } = toClientError(error);
            refused.push({ name, reason: `${title}: ${detail} (${code})` });
          } finally {
            sending.current.delete(name);
          }
        }
        notice.update(results);
      });

      function reasonOf(operation: Operation, name: string, underWay: boolean): string | null {
        const robot = store.get("robots").get(name);
        const live = store.get("connection").phase === "live";
        return robot === undefined ? "It has left the ROS graph." : whyNot(operation, robot, live, underWay);
      }
    },
    [http, gatewayOf, store],
  );
}
