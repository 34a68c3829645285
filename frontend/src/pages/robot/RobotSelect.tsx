import { Select } from "@mantine/core";
import { useLocation, useNavigate, useSearchParams } from "react-router";
import { useNaming } from "../../fleet/context";
import { readTab, robotPath } from "../../fleet/names";

/** Said with an address that was chosen here: the focus stays. */
const SWITCHED = "switched";

/**
 * Goes to the robot that is chosen, on the same tab. With that robot's name as its key: one that was just closed forgets
 * its highlight up to 100 ms later, and Enter would find none.
 */
export default function RobotSelect({ others }: { others: readonly string[] }) {
  const naming = useNaming();
  const navigate = useNavigate();
  const [query] = useSearchParams();
  const { state } = useLocation();
  return (
    <Select
      aria-label="Switch robot"
      placeholder="Switch robot"
      data={others.map((name) => ({ value: name, label: naming.fullNameOf(name) }))}
      value={null}
      searchable
      autoFocus={state === SWITCHED}
      openOnFocus={false}
      nothingFoundMessage="No such robot"
      // The first match is highlighted as soon as there is a list, and stays so: without these, Mantine forgets it after opening.
      selectFirstOptionOnChange
      selectFirstOptionOnDropdownOpen
      comboboxProps={{ transitionProps: { duration: 0 } }}
      onChange={(name) => {
        if (name !== null) navigate(robotPath(name, readTab(query)), { state: SWITCHED });
      }}
    />
  );
}
