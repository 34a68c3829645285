import { isTerminal } from "@dock-gateway/client";
import { Skeleton, Stack, Text, Title } from "@mantine/core";
import { Suspense } from "react";
import { useParams } from "react-router";
import { apiAddress } from "../api/site";
import { Parts } from "../extension/context";
import { useNaming } from "../fleet/context";
import { goalTitle } from "../goal/words";
import { Command } from "../ui/CopyButton";
import { Trouble } from "../ui/errors";
import { Guarded } from "../ui/Guarded";
import { lazyPart } from "../ui/lazyPart";
import { usePageTitle } from "../ui/Section";
import { FeedbackSection } from "./FeedbackSection";
import { GoalHead } from "./GoalHead";
import { GoalMessages } from "./GoalMessages";
import { GoalTimeline } from "./GoalTimeline";
import classes from "./goalPage.module.css";
import { MotionPlots } from "./MotionPlots";
import { NotesSection } from "./NotesSection";
import { Replay } from "./Replay";
import { useGoalWatch, useWatched, useWatchTopic, WatchedContext } from "./useGoalWatch";

const ReplayMap = lazyPart(() => import("./ReplayMap"));

/** One goal, whatever its action: what was asked, what happened and how it ended, as it happens. */
export default function GoalPage() {
  const { goalId = "" } = useParams();
  const watched = useGoalWatch(goalId);
  if (watched === null) return <GoalSkeleton />;
  return (
    <WatchedContext.Provider value={watched}>
      <WatchedGoal />
    </WatchedContext.Provider>
  );
}

function WatchedGoal() {
  const { watch } = useWatched();
  const goal = useWatchTopic("goal");
  const error = useWatchTopic("error");
  const naming = useNaming();
  usePageTitle(goal === null ? "Goal" : `${goal.status}: ${goalTitle(goal, naming)}`);
  if (goal === null) {
    if (error === null) return <GoalSkeleton />;
    return (
      <>
        <GoalTitle />
        <Trouble what="The goal could not be loaded" error={error} onRetry={() => void watch.open()} />
        <Stack gap="xs">
          <Text size="sm" c="dimmed">
            The goals that the gateway knows:
          </Text>
          <Command line={`curl '${apiAddress()}/goals'`} what="the command that lists goals" />
        </Stack>
      </>
    );
  }
  return (
    <>
      <GoalHead goal={goal} />
      {isTerminal(goal.status) && <Replay goal={goal} />}
      <div className={classes.grid}>
        <Stack gap="md">
          {isTerminal(goal.status) && (
            <Guarded of={goal.goal_id}>
              <Suspense fallback={null}>
                <ReplayMap goal={goal} />
              </Suspense>
            </Guarded>
          )}
          <GoalTimeline goal={goal} />
          <NotesSection goalId={goal.goal_id} />
        </Stack>
        <Stack gap="md" className={classes.longest}>
          {isTerminal(goal.status) && goal.verb !== null && <MotionPlots goal={goal} />}
          <Parts at="goalPanels" goal={goal} quiet />
          <FeedbackSection goal={goal} />
        </Stack>
        <GoalMessages goal={goal} />
      </div>
    </>
  );
}

function GoalTitle() {
  return (
    <Title order={1} size="h3">
      Goal
    </Title>
  );
}

/** About as large as what comes. */
function GoalSkeleton() {
  return (
    <Stack gap="md" aria-busy="true">
      <GoalTitle />
      <Skeleton height={190} />
      <div className={classes.grid}>
        <Skeleton height={420} />
        <Skeleton height={900} className={classes.longest} />
        <Skeleton height={300} />
      </div>
    </Stack>
  );
}
