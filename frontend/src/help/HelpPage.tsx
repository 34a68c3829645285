import { Anchor, List, Loader, Skeleton, Stack, Text, TextInput, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { type MouseEvent, useDeferredValue, useEffect, useMemo, useRef } from "react";
import { Link, useLocation, useNavigate, useParams } from "react-router";
import { Address, text, useAddress } from "../ui/address";
import { PageTitle, usePageTitle } from "../ui/Section";
import type { HelpDocument, HelpSection } from "./document";
import classes from "./help.module.css";
import { FOR_CONTRIBUTORS, helpPath, INDEX, loadPage, PAGE_NAMES } from "./pages";
import { search, searched } from "./search";

const address = new Address({ query: text("q") });

/** A page of the documentation, and a search in all of them. */
export default function HelpPage() {
  const name = useParams()["*"] || INDEX;
  const [{ query }, change] = useAddress(address);
  return (
    <Stack gap="md" className={classes.help ?? ""}>
      <TextInput
        type="search"
        aria-label="Search the help"
        placeholder="Search the help"
        value={query}
        onChange={(event) => change({ query: event.currentTarget.value })}
      />
      {query.trim() === "" ? <Document key={name} name={name} /> : <Results query={query} />}
    </Stack>
  );
}

function Document({ name }: { name: string }) {
  const { data, error } = useQuery({
    queryKey: ["help", name],
    queryFn: () => loadPage(name),
    staleTime: Number.POSITIVE_INFINITY,
  });
  if (error !== null) throw error;
  if (data === undefined) return <Skeleton height={320} />;
  if (data === null) return <NoPage />;
  return <Shown name={name} page={data} />;
}

function NoPage() {
  return (
    <>
      <PageTitle title="No such page of the help" />
      <Text>
        It may be about a part of the gateway that is not installed here. See{" "}
        <Anchor component={Link} to={helpPath(INDEX)}>
          all pages
        </Anchor>
        .
      </Text>
    </>
  );
}

function Shown({ name, page: { sections } }: { name: string; page: HelpDocument }) {
  const { hash } = useLocation();
  const shown = useRef<HTMLElement>(null);
  const follow = useFollow();
  const [first, ...others] = sections;
  usePageTitle(`${first?.title} · Help`);
  useEffect(() => {
    if (hash === "") return;
    const heading = document.getElementById(decodeURIComponent(hash.slice(1)));
    if (heading === null || shown.current?.contains(heading) !== true) return;
    heading.scrollIntoView();
    heading.focus({ preventScroll: true });
  }, [hash]);
  return (
    // biome-ignore lint/a11y/useKeyWithClickEvents: a link that is followed by the keyboard is clicked as well
    <article ref={shown} onClick={follow}>
      <div className={classes.text}>
        <h1 id={first?.id} tabIndex={-1}>
          {first?.title}
        </h1>
        {first !== undefined && <Body section={first} />}
        {name !== INDEX && others.length > 2 && <Contents name={name} sections={others} />}
        {others.map((section) => (
          <section key={section.id} aria-labelledby={section.id}>
            <Heading section={section} />
            <Body section={section} />
          </section>
        ))}
      </div>
      {name === INDEX ? (
        <Anchor href="/docs" size="sm">
          Try the API of this gateway
        </Anchor>
      ) : (
        <Anchor component={Link} to={helpPath(INDEX)} size="sm">
          All pages of the help
        </Anchor>
      )}
    </article>
  );
}

function Heading({ section: { id, title, level } }: { section: HelpSection }) {
  const Tag = level <= 2 ? "h2" : "h3";
  return (
    <Tag id={id} tabIndex={-1}>
      {title}
    </Tag>
  );
}

function Body({ section }: { section: HelpSection }) {
  // biome-ignore lint/security/noDangerouslySetInnerHtml: made of our own documentation when the dashboard was built
  return <div dangerouslySetInnerHTML={{ __html: section.html }} />;
}

/** The headings of a long page. */
function Contents({ name, sections }: { name: string; sections: readonly HelpSection[] }) {
  return (
    <nav aria-label="On this page">
      <ul>
        {sections
          .filter(({ level }) => level === 2)
          .map(({ id, title }) => (
            <li key={id}>
              <a href={helpPath(name, id)}>{title}</a>
            </li>
          ))}
      </ul>
    </nav>
  );
}

/** Links between pages stay in the dashboard, which is not loaded again. */
function useFollow() {
  const navigate = useNavigate();
  return (event: MouseEvent) => {
    if (event.button !== 0 || event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) return;
    const link = event.target instanceof Element ? event.target.closest("a[href^='/ui/help']") : null;
    if (link === null || event.defaultPrevented) return;
    event.preventDefault();
    void navigate(link.getAttribute("href") ?? "");
  };
}

function Results({ query }: { query: string }) {
  usePageTitle("Help");
  const wanted = useDeferredValue(query);
  const { data: sections, error } = useQuery({
    queryKey: ["help"],
    queryFn: loadAll,
    staleTime: Number.POSITIVE_INFINITY,
  });
  const hits = useMemo(() => (sections === undefined ? [] : search(wanted, sections)), [wanted, sections]);
  if (error !== null) throw error;
  if (sections === undefined) return <Loader aria-label="The pages are loading" />;
  return (
    <>
      <div role="status">
        <Title order={1} size="h3">
          {hits.length === 0 ? "Nothing found" : "Found in the help"}
        </Title>
      </div>
      {hits.length === 0 && <Text>Try fewer words, or only the beginning of one.</Text>}
      <List listStyleType="none" spacing="md">
        {hits.map(({ page, pageTitle, id, title, excerpt }) => (
          <List.Item key={`${page}#${id}`}>
            <Anchor component={Link} to={helpPath(page, id)} fw={600}>
              {title === pageTitle ? title : `${pageTitle}: ${title}`}
            </Anchor>
            <Text size="sm" c="dimmed">
              {excerpt}
            </Text>
          </List.Item>
        ))}
      </List>
    </>
  );
}

async function loadAll() {
  const pages = await Promise.all(
    PAGE_NAMES.filter((name) => !FOR_CONTRIBUTORS.includes(name)).map(
      async (name): Promise<[string, HelpDocument]> => {
        const page = await loadPage(name);
        return [name, page ?? { sections: [] }];
      },
    ),
  );
  return searched(pages);
}
