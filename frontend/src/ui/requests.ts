import {
  type QueryFunctionContext,
  type UseMutationResult,
  type UseQueryOptions,
  type UseQueryResult,
  useMutation,
  useQuery,
} from "@tanstack/react-query";
import { type CommandError, toCommandError } from "../api/errors";

function failing(error: unknown): never {
  throw toCommandError(error);
}

/** A command to the gateway, sent once for each call and never again by itself. */
export function useCommand<Result, Input = void>(
  send: (input: Input) => Promise<Result>,
): UseMutationResult<Result, CommandError, Input> {
  return useMutation<Result, CommandError, Input>({
    // By default a mutation made while the browser is offline waits, and is sent when it is back.
    networkMode: "always",
    retry: false,
    mutationFn: (input) => send(input).catch(failing),
  });
}

interface AnswerOptions<Answer, Shown> extends Omit<UseQueryOptions<Answer, CommandError, Shown>, "queryFn"> {
  queryFn: (context: QueryFunctionContext) => Promise<Answer>;
}

/** What the gateway answers to a request; every failure is a CommandError. */
export function useAnswer<Answer, Shown = Answer>({
  queryFn,
  ...options
}: AnswerOptions<Answer, Shown>): UseQueryResult<Shown, CommandError> {
  return useQuery<Answer, CommandError, Shown>({
    ...options,
    queryFn: (context) => queryFn(context).catch(failing),
  });
}
