import { Paper, Stack, Text, Title } from "@mantine/core";
import { usePageTitle } from "../ui/Section";
import classes from "./access.module.css";
import LoginForm from "./LoginForm";

/** What is shown instead of the pages until somebody has logged in. */
export default function LoginPage() {
  usePageTitle("Log in");
  return (
    <main className={classes.login}>
      <Paper withBorder radius="md" p={{ base: "md", sm: "xl" }} w="100%" maw="28rem">
        <Stack gap="md">
          <div>
            <Text fw={700}>dock-gateway</Text>
            <Title order={1} size="h3">
              Log in
            </Title>
          </div>
          <LoginForm />
        </Stack>
      </Paper>
    </main>
  );
}
