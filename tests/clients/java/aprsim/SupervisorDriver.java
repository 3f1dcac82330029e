package aprsim;

import aprs.database.PhysicalItem;
import aprs.simview.Object2DOuterJPanel;
import aprs.supervisor.main.Supervisor;
import crcl.ui.misc.MultiLineStringJPanel;
import crcl.utils.CRCLUtils;
import crcl.utils.XFutureVoid;
import java.io.File;
import java.lang.reflect.Field;
import java.lang.reflect.Method;
import java.util.Arrays;
import java.util.List;
import java.util.stream.Collectors;

/**
 * The framework's supervisor with all systems of a setup file, without a display. open SETUP POSITION_MAPS TEACH; teach
 * LAYOUT, as one chooses it in its menu; cycles NUMBER, scan all and then kits emptied and filled by all robots at once, so
 * often.
 */
public final class SupervisorDriver {
  public static void main(String[] unused) throws Exception {
    CRCLUtils.setAllowExit(false);
    CRCLUtils.setForceHeadless(true);
    MultiLineStringJPanel.disableShowText = true;
    MultiLineStringJPanel.setIgnoreForceShow(true);
    Supervisor supervisor = Supervisor.createSupervisor();
    Console.serve(
        (command, arguments) -> {
          switch (command) {
            case "open":
              supervisor.loadSetupFile(new File(arguments[0])).get();
              call(supervisor, "loadPositionMappingsFilesFile", new File(arguments[1]));
              ((XFutureVoid) call(supervisor, "loadTeachPropertiesFile", new File(arguments[2]))).get();
              return "done";
            case "teach":
              return teach(supervisor, new File(arguments[0]));
            case "cycles":
              int cycles = Integer.parseInt(arguments[0]);
              call(supervisor, "setMax_cycles", cycles);
              XFutureVoid scanned = (XFutureVoid) call(supervisor, "startScanAll");
              Console.follow(
                  "cycles",
                  scanned
                      .thenCompose(x -> demo(supervisor))
                      .thenApply(x -> supervisor.getContiousDemoCycleCount() == cycles),
                  () -> supervisor.getContiousDemoCycleCount() + " cycles");
              return null;
            default:
              throw new IllegalArgumentException(command);
          }
        });
  }

  private static XFutureVoid demo(Supervisor supervisor) {
    try {
      return (XFutureVoid) call(supervisor, "startContinuousDemoRevFirst");
    } catch (Exception fault) {
      throw new IllegalStateException(fault);
    }
  }

  /** Loads a layout of the teach table until it stays: the view goes on loading its properties after it says that it has. */
  private static String teach(Supervisor supervisor, File layout) throws Exception {
    Field field = Supervisor.class.getDeclaredField("object2DOuterJPanel1");
    field.setAccessible(true);
    Object2DOuterJPanel view = (Object2DOuterJPanel) field.get(supervisor);
    List<String> wanted = names(view.csvFileToItemsList(layout, false, false));
    for (int stayed = 0, tries = 0; stayed < 20; ++tries) {
      if (tries == 300) return "shows " + names(view.getItems());
      if (names(view.getItems()).equals(wanted)) {
        ++stayed;
      } else {
        stayed = 0;
        view.loadFile(layout).get();
      }
      Thread.sleep(100);
    }
    return "done";
  }

  private static List<String> names(List<PhysicalItem> items) {
    return items.stream().map(PhysicalItem::getName).sorted().collect(Collectors.toList());
  }

  /** A method of the supervisor that only its display calls. */
  private static Object call(Object whose, String name, Object... arguments) throws Exception {
    Class<?>[] types =
        Arrays.stream(arguments)
            .map(argument -> argument instanceof Integer ? int.class : argument.getClass())
            .toArray(Class<?>[]::new);
    Method method = whose.getClass().getDeclaredMethod(name, types);
    method.setAccessible(true);
    return method.invoke(whose, arguments);
  }
}
