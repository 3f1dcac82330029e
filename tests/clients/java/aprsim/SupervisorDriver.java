package aprsim;

import aprs.supervisor.main.Supervisor;
import crcl.ui.misc.MultiLineStringJPanel;
import crcl.utils.CRCLUtils;
import crcl.utils.XFutureVoid;
import java.io.File;
import java.lang.reflect.Method;

/**
 * The framework's supervisor with all systems of a setup file, without a display. open SETUP POSITION_MAPS TEACH; cycles
 * NUMBER; count.
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
            case "cycles":
              new Thread(
                      () -> {
                        try {
                          Supervisor.MultiCycleResults results =
                              supervisor
                                  .completeMultiCycleTest(
                                      System.currentTimeMillis(), Integer.parseInt(arguments[0]), false)
                                  .get();
                          Console.say("cycles ended " + (results.cyclesComplete == results.numCycles) + " " + results.msg);
                        } catch (Throwable fault) {
                          fault.printStackTrace();
                          Console.say("cycles ended false " + Console.reason(fault));
                        }
                      })
                  .start();
              return null;
            case "count":
              return String.valueOf(supervisor.getContiousDemoCycleCount());
            default:
              throw new IllegalArgumentException(command);
          }
        });
  }

  /** A method of the supervisor that only its display calls. */
  private static Object call(Supervisor supervisor, String name, Object argument) throws Exception {
    Method method = Supervisor.class.getDeclaredMethod(name, argument.getClass());
    method.setAccessible(true);
    return method.invoke(supervisor, argument);
  }
}
