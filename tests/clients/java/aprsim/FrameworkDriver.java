package aprsim;

import aprs.system.AprsSystem;
import crcl.ui.misc.MultiLineStringJPanel;
import crcl.utils.CRCLUtils;
import crcl.utils.XFuture;
import java.io.File;

/**
 * One system of the APRS framework without a display. open PROPERTIES; tool NAME; connect NAME PORT; start ACTIONS; pause;
 * resume; abort; safe-abort; continue; reset; disconnect; state.
 */
public final class FrameworkDriver {
  private static AprsSystem system;

  public static void main(String[] unused) throws Exception {
    CRCLUtils.setAllowExit(false);
    CRCLUtils.setForceHeadless(true);
    MultiLineStringJPanel.disableShowText = true;
    MultiLineStringJPanel.setIgnoreForceShow(true);
    Console.serve(
        (command, arguments) -> {
          switch (command) {
            case "open":
              system = AprsSystem.createSystem(new File(arguments[0])).get();
              return system.getRobotName() + " " + system.getRobotCrclPort();
            case "tool":
              system.overwriteCurrentToolName(arguments[0]);
              return "done";
            case "connect":
              system
                  .connectRobot(arguments[0], "localhost", Integer.parseInt(arguments[1]))
                  .get();
              return String.valueOf(system.isConnected());
            case "disconnect":
              system.disconnectRobot().get();
              return String.valueOf(system.isConnected());
            case "start":
              // As its display does it; what startActionsFile has begun never completes a safe abort.
              system.loadActionsFile(new File(arguments[0]));
              follow("start", system.startActions("driver", false));
              return null;
            case "continue":
              follow("continue", system.continueActionList("driver"));
              return null;
            case "pause":
              system.pause();
              return "done";
            case "resume":
              system.resume();
              return "done";
            case "abort":
              system.immediateAbort(Thread.currentThread().getStackTrace()).get();
              return "done";
            case "safe-abort":
              system.startSafeAbortAndDisconnect("driver").get();
              return "done";
            case "reset":
              system.reset(true).get();
              return "done";
            case "state":
              return "paused=" + system.isPaused() + " running=" + system.isRunningCrclProgram()
                  + " doing=" + system.isDoingActions() + " connected=" + system.isConnected()
                  + " title=" + system.getTitleErrorString() + " crcl=" + system.getCrclClientErrorString();
            default:
              throw new IllegalArgumentException(command);
          }
        });
  }

  private static void follow(String name, XFuture<Boolean> result) {
    Console.follow(name, result, () -> "title=" + system.getTitleErrorString());
  }
}
